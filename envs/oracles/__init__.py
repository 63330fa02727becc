"""Scripted policies that collect data, by name.

OGBench's policies combine the choice of the next cube (`targets`) with a way of moving it (`plan`
or `markov`); `replan` is that of a real robot. All are pure functions of a key and the perceived
state of the simulation.
"""

from pigbench.envs.oracles.noisy import NoisyPolicy
from pigbench.envs.oracles.play import PlayPolicy
from pigbench.envs.oracles.policy import ScriptedPolicy
from pigbench.envs.oracles.replan import ReplanPolicy

POLICIES: dict[str, type[ScriptedPolicy]] = {
    "play": PlayPolicy,
    "noisy": NoisyPolicy,
    "replan": ReplanPolicy,
}

__all__ = ["POLICIES", "NoisyPolicy", "PlayPolicy", "ReplanPolicy", "ScriptedPolicy"]
