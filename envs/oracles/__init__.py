"""Scripted policies that collect data, by name.

OGBench's are which cube next (`targets`) and how to move it (`plan` or `markov`); `replan` is a
robot's. All are pure functions of a key and of the simulation's state, as it seems.
"""

from pigbench.envs.oracles.noisy import NoisyPolicy
from pigbench.envs.oracles.play import PlayPolicy
from pigbench.envs.oracles.policy import Policy
from pigbench.envs.oracles.replan import ReplanPolicy

POLICIES: dict[str, type[Policy]] = {
    "play": PlayPolicy,
    "noisy": NoisyPolicy,
    "replan": ReplanPolicy,
}

__all__ = ["POLICIES", "NoisyPolicy", "PlayPolicy", "Policy", "ReplanPolicy"]
