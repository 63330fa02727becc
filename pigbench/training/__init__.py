"""Runs: training, evaluation, and what they leave in a folder."""
