"""Offline goal-conditioned RL on contact-rich manipulation: environments, agents, evaluation."""

from pigbench import xla

xla.avoid_wrong_sums()
