"""Benchmarks: how long things take, ours beside what they are compared with, in one run."""
