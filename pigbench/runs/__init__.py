"""Runs: the files that training leaves in a folder, and what can be restored from them."""
