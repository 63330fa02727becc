"""The names that `pigbench.agents` exports and that need JAX."""

from pigbench.agents.agent import Agent, Params
from pigbench.agents.batch import Batch, GoalMixture, Sampling, Subgoals, SubgoalSampling
from pigbench.agents.config import AgentConfig
from pigbench.agents.constraints import (
    Constraint,
    EikonalConstraint,
    HJBConstraint,
    TransitionConstraint,
)
from pigbench.agents.crl import CRL, CRLConfig
from pigbench.agents.flow_clone import FlowClone, FlowCloneConfig
from pigbench.agents.flow_hierarchy import FlowHierarchy, FlowHierarchyConfig
from pigbench.agents.gcbc import GCBC
from pigbench.agents.gciql import GCIQL, GCIQLConfig
from pigbench.agents.gcivl import GCIVL, GCIVLConfig
from pigbench.agents.hiql import HIQL, HIQLConfig
from pigbench.agents.learner import TrainState, create, update
from pigbench.agents.metrics import Metrics
from pigbench.agents.qrl import QRL, AWRExtraction, DDPGBCExtraction, QRLConfig
from pigbench.agents.registry import Method, build, get, hierarchy, register
from pigbench.agents.regularizers import (
    EikonalRegularizer,
    HJBRegularizer,
    NoRegularizer,
    Regularizer,
)
from pigbench.agents.statistics import Statistics

__all__ = [
    "CRL",
    "GCBC",
    "GCIQL",
    "GCIVL",
    "HIQL",
    "QRL",
    "AWRExtraction",
    "Agent",
    "AgentConfig",
    "Batch",
    "CRLConfig",
    "Constraint",
    "DDPGBCExtraction",
    "EikonalConstraint",
    "EikonalRegularizer",
    "FlowClone",
    "FlowCloneConfig",
    "FlowHierarchy",
    "FlowHierarchyConfig",
    "GCIQLConfig",
    "GCIVLConfig",
    "GoalMixture",
    "HIQLConfig",
    "HJBConstraint",
    "HJBRegularizer",
    "Method",
    "Metrics",
    "NoRegularizer",
    "Params",
    "QRLConfig",
    "Regularizer",
    "Sampling",
    "Statistics",
    "SubgoalSampling",
    "Subgoals",
    "TrainState",
    "TransitionConstraint",
    "build",
    "create",
    "get",
    "hierarchy",
    "register",
    "update",
]
