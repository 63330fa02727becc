"""Offline goal-conditioned RL on contact-rich manipulation: environments, agents, evaluation."""

from pigbench import opengl, xla

xla.avoid_wrong_sums()
opengl.spare_mujoco()

from pigbench import gym  # noqa: E402  after the settings that must precede JAX

gym.register()
