"""Benchmarks: running times of ours and of what they are compared with, measured in one run."""
