"""What runs achieved: statistics, tables and pictures, from saved files alone."""
