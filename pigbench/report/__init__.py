"""Results of runs: statistics, tables and figures, from saved files alone."""
