"""What all of the harness stands on: crash-safe files, comparing settings, progress."""
