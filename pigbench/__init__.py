"""Offline goal-conditioned RL on contact-rich manipulation: environments, agents, evaluation."""
