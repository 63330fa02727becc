"""Foundations of the harness: crash-safe files, comparison of settings, progress."""
