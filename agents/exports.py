"""The names that `pigbench.agents` exports and that need JAX."""

from pigbench.agents.agent import Agent, Params
from pigbench.agents.batch import (
    Batch,
    Sampling,
    Subgoals,
    SubgoalSampling,
    ValueGoals,
)
from pigbench.agents.config import AgentConfig, PolicyConfig, TargetConfig, ValueConfig
from pigbench.agents.constraints import (
    Constraint,
    EikonalConstraint,
    HJBConstraint,
    TransitionConstraint,
)
from pigbench.agents.crl import CRL, CRLConfig
from pigbench.agents.flow_clone import BestOfFlow, BestOfFlowConfig, FlowClone, FlowCloneConfig
from pigbench.agents.flow_hierarchy import FlowHierarchy, FlowHierarchyConfig
from pigbench.agents.gcbc import GCBC
from pigbench.agents.gciql import GCIQL, GCIQLConfig
from pigbench.agents.gcivl import GCIVL, GCIVLConfig
from pigbench.agents.goals import GoalMixture
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
    "BestOfFlow",
    "BestOfFlowConfig",
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
    "PolicyConfig",
    "QRLConfig",
    "Regularizer",
    "Sampling",
    "Statistics",
    "SubgoalSampling",
    "Subgoals",
    "TargetConfig",
    "TrainState",
    "TransitionConstraint",
    "ValueConfig",
    "ValueGoals",
    "build",
    "create",
    "get",
    "hierarchy",
    "register",
    "update",
]
