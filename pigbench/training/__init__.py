"""Runs: training, evaluation, and the files that they leave in a folder."""
