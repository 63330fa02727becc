"""Scripted policies that collect data, by name.

A policy is which cube next (`targets`) and how to move it (`plan` or `markov`), all pure
functions of a key and the simulation's state.
"""

from pigbench.envs.oracles.noisy import NoisyPolicy
from pigbench.envs.oracles.play import PlayPolicy
from pigbench.envs.oracles.policy import Policy

POLICIES: dict[str, type[Policy]] = {"play": PlayPolicy, "noisy": NoisyPolicy}

__all__ = ["POLICIES", "NoisyPolicy", "PlayPolicy", "Policy"]
