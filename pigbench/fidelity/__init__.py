"""How close the environments and their data are to OGBench's, measured against its package."""
