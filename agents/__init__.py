"""Offline goal-conditioned agents: losses, regularisers, networks, and the methods made of them."""

from pigbench.agents.agent import Agent, Metrics, Params
from pigbench.agents.batch import Batch, GoalMixture, Sampling
from pigbench.agents.config import AgentConfig
from pigbench.agents.gcivl import GCIVL, GCIVLConfig
from pigbench.agents.learner import TrainState, create, update
from pigbench.agents.registry import Method, build, get, names, register
from pigbench.agents.regularizers import Regularizer

__all__ = [
    "GCIVL",
    "Agent",
    "AgentConfig",
    "Batch",
    "GCIVLConfig",
    "GoalMixture",
    "Method",
    "Metrics",
    "Params",
    "Regularizer",
    "Sampling",
    "TrainState",
    "build",
    "create",
    "get",
    "names",
    "register",
    "update",
]
