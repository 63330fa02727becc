"""Hierarchies with a flow of subgoals: the high level of H-Flow, Pi-H-Flow, SHARSA and DSHARSA.

The high level draws candidate subgoals, K steps ahead and in the low level's representation x, from
a flow, and its critic picks one; the low level is any agent on x without subgoals of its own. This
follows the training and inference algorithms of the paper's appendix and, where they leave a
choice, SHARSA (Park et al., 2025).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, PRNGKeyArray, Scalar

from pigbench.agents.agent import Agent, Params
from pigbench.agents.batch import Batch, Sampling, SubgoalSampling, ValueGoals
from pigbench.agents.config import AgentConfig, TargetConfig, no_effect
from pigbench.agents.constraints import Constraint
from pigbench.agents.flow import FlowPolicy
from pigbench.agents.gcivl import GCIVLConfig
from pigbench.agents.goals import (
    GOALS,
    HIERARCHY_ACTOR_GOALS,
    HIERARCHY_VALUE_GOALS,
    GoalMixture,
)
from pigbench.agents.metrics import LossAndMetrics, add_prefix, combine, take_prefix
from pigbench.agents.regularizers import Regularizer
from pigbench.agents.representations import REPRESENTATIONS, Representation
from pigbench.agents.sarsa import Sarsa
from pigbench.agents.statistics import Statistics, require_statistics
from pigbench.errors import UserError, lookup, require
from pigbench.layout import Space
from pigbench.shapes import Array

T = TypeVar("T")


@dataclass(frozen=True)
class FlowHierarchyConfig(TargetConfig):
    """Hyperparameters of both levels; those outside `low` are the high level's, or shared.

    Raises `UserError` if `low` changes a field that the hierarchy decides.
    """

    decided = (
        "low.learning_rate",
        "low.batch_size",
        "low.target_rate",
        "low.discount",
        "low.goals",
        "low.actor_goals",
    )

    value_goals: GoalMixture = HIERARCHY_VALUE_GOALS
    actor_goals: GoalMixture = HIERARCHY_ACTOR_GOALS
    subgoal_steps: int = 25  # K: how many steps ahead subgoals are
    low_level_representation: str = "joints_contacts"  # joints_contacts, proprio or full
    standardize: bool = True  # standardise the inputs of the low level and all subgoals
    flow_steps: int = 10  # M: Euler steps of the flow
    candidates: int = 32  # N: subgoals drawn, of which the critic picks the best
    average_rate: float = 1.0  # below 1, act with parameters averaged over about 1 / rate updates
    low: AgentConfig = field(default_factory=GCIVLConfig)  # the low level's own configuration

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, lambda x: x >= 2, "at least 2", "subgoal_steps")
        require(self, lambda x: x >= 1, "at least 1", "flow_steps", "candidates")
        require(self, lambda x: 0 < x <= 1, "above 0 and at most 1", "average_rate")
        lookup("representation", REPRESENTATIONS, self.low_level_representation)
        unchanged = type(self.low)()
        for place in self.decided:
            name = place.removeprefix("low.")
            if getattr(self.low, name, None) != getattr(unchanged, name, None):
                raise no_effect(place)

    @property
    def low_discount(self) -> float:
        """1 - 1/K, so that the low level's horizon is about that of its subgoals."""
        return 1 - 1 / self.subgoal_steps


class FlowHierarchy(Agent[FlowHierarchyConfig]):
    """A high level that gives subgoals to the agent `low`, which is built from `config.low`.

    The names of networks and metrics start with "high_" or "low_". Raises `UserError` if the low
    level has subgoals of its own, as HIQL and hierarchies do.
    """

    supported_goals = tuple(GOALS)

    def __init__(
        self,
        config: FlowHierarchyConfig,
        space: Space,
        *,
        low: Callable[..., Agent[Any]],
        statistics: Statistics | None = None,
        units: Float[np.ndarray, "observation"] | float = 1.0,
    ) -> None:
        super().__init__(config, space, statistics=statistics, units=units)
        self.represent = Representation(
            config.low_level_representation,
            space.layout,
            require_statistics(statistics, "standardize") if config.standardize else None,
        )
        self.low = low(
            replace(config.low, discount=config.low_discount),
            Space(self.represent.layout, space.action_size),
            statistics=self.represent.statistics(statistics),
            units=self.represent.units,
        )
        if self.low.sampling.subgoals:
            raise UserError(
                f"{type(self.low).__name__} has subgoals of its own, so it cannot be the low level "
                "of a hierarchy: choose an agent without, such as GCIVL"
            )
        self.average_rate = config.average_rate
        self.target_networks = (
            "high_critic",
            *(f"low_{name}" for name in self.low.target_networks),
        )

    @property
    def sampling(self) -> Sampling:
        """The high level's goals; the low level's actor goals are the states K steps ahead."""
        low = self.low.sampling
        subgoals = SubgoalSampling(self.config.subgoal_steps, low.value_goals, low.discount)
        return replace(super().sampling, subgoals=subgoals)

    @cached_property
    def actor(self) -> FlowPolicy:
        """The flow of subgoals."""
        config = self.config
        return FlowPolicy(
            config.actor_hidden_sizes, self.represent.size, config.layer_norm, config.flow_steps
        )

    @cached_property
    def values(self) -> Sarsa:
        """The critic of subgoals."""
        return Sarsa(self.config.value_hidden_sizes, self.config.layer_norm)

    def init(self, key: PRNGKeyArray) -> Params:
        """Parameters of "high_actor", "high_critic", "high_value" and the low level."""
        actor_key, values_key, low_key = jax.random.split(key, 3)
        subgoals = jnp.zeros(self.represent.size)
        high = {
            "actor": self.actor.init(actor_key, **self.inputs),
            **self.values.init(values_key, **self.inputs, actions=subgoals),
        }
        return _named_by_level(high, self.low.init(low_key))

    def loss(
        self, params: Params, target_params: Params, batch: Batch, key: PRNGKeyArray
    ) -> LossAndMetrics:
        """The sum of both levels' losses, which train disjoint networks."""
        high, low = _levels(params)
        high_targets, low_targets = _levels(target_params)
        high_key, low_key = jax.random.split(key)
        high_loss, high_metrics = self._high_loss(high, high_targets, batch, high_key)
        low_loss, low_metrics = self.low.loss(low, low_targets, self._low_batch(batch), low_key)
        return high_loss + low_loss, _named_by_level(high_metrics, low_metrics)

    def act(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        goal: Float[Array, "observation"],
        key: PRNGKeyArray,
    ) -> Float[Array, "action"]:
        """The low level's action towards a subgoal newly drawn by the high level."""
        subgoal_key, low_key = jax.random.split(key)
        subgoal = self.subgoal(params, observation, goal, subgoal_key)
        return self.follow(params, observation, subgoal, low_key)

    def subgoal(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        goal: Float[Array, "observation"],
        key: PRNGKeyArray,
    ) -> Float[Array, "x"]:
        """The best of `candidates` samples of the flow."""
        high, _ = _levels(params)
        inputs = {"observation": observation, "goal": self.as_goals(goal)}
        count = self.config.candidates
        candidates = self.actor.sample(high["actor"], **inputs, count=count, key=key)
        return self.values.best(high, **inputs, candidates=candidates)

    def follow(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        subgoal: Float[Array, "x"],
        key: PRNGKeyArray,
    ) -> Float[Array, "action"]:
        """The low level's action towards `subgoal`."""
        _, low = _levels(params)
        return self.low.act(low, self.represent(observation), subgoal, key)

    def state_value(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        goal: Float[Array, "observation"],
    ) -> Scalar:
        """The low level's value, of both states in its representation."""
        _, low = _levels(params)
        return self.low.state_value(low, self.represent(observation), self.represent(goal))

    @property
    def penalty(self) -> Regularizer | Constraint:
        """The low level's."""
        return self.low.penalty

    def value_learner(self, params: Params, batch: Batch) -> tuple[Agent[Any], Params, Batch]:
        """The low level, and the batch in its representation, with the goals that it learns on."""
        _, low = _levels(params)
        return self.low, low, self._low_batch(batch)

    def _high_loss(
        self,
        params: Params,
        target_params: Params,
        batch: Batch,
        key: PRNGKeyArray,
    ) -> LossAndMetrics:
        subgoals = batch.required_subgoals
        return combine(
            self.actor.loss(
                params["actor"],
                observations=batch.observations,
                goals=self.as_goals(batch.actor_goals),
                samples=self.represent(subgoals.actor_subgoals),
                key=key,
            ),
            self.values.loss(
                params,
                target_params,
                observations=batch.observations,
                actions=self.represent(subgoals.value_subgoals),
                goals=self.as_goals(batch.value_goals),
                next_observations=subgoals.value_subgoals,
                success=subgoals.value_success,
                discounts=self.config.discount**subgoals.value_steps,
            ),
        )

    def _low_batch(self, batch: Batch) -> Batch:
        subgoals = batch.required_subgoals
        low = subgoals.low_for_value
        return Batch(
            observations=self.represent(batch.observations),
            actions=batch.actions,
            next_observations=self.represent(batch.next_observations),
            actor_goals=self.represent(subgoals.low_actor_goals),
            for_value=low and ValueGoals(self.represent(low.states), low.success),
        )


def _named_by_level(high: Mapping[str, T], low: Mapping[str, T]) -> dict[str, T]:
    return add_prefix("high_", high) | add_prefix("low_", low)


def _levels(named: Mapping[str, T]) -> tuple[dict[str, T], dict[str, T]]:
    return take_prefix("high_", named), take_prefix("low_", named)
