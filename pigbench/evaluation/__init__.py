"""Evaluation of policies: rollouts, what is measured in them, and their rows and films."""
