"""Runs: training, and the files that it leaves in a folder."""
