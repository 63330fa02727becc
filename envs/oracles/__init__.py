"""Scripted policies that collect data, by name.

A policy is which cube next (`targets`) and how to move it (`plan`), both pure functions of
a key and the simulation's state.
"""

from pigbench.envs.oracles.play import PlayPolicy
from pigbench.envs.oracles.policy import Policy

POLICIES: dict[str, type[Policy]] = {"play": PlayPolicy}

__all__ = ["POLICIES", "PlayPolicy", "Policy"]
