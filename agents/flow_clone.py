"""The low levels of SHARSA and DSHARSA: behaviour cloning with a flow, and its best sample.

Park et al. (2025), "Horizon Reduction Makes RL Scalable". Their high level is in
`flow_hierarchy.py`.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Float, PRNGKeyArray

from pigbench.agents.agent import Agent, Params
from pigbench.agents.batch import Batch
from pigbench.agents.config import AgentConfig, TargetConfig
from pigbench.agents.flow import FlowPolicy
from pigbench.agents.goals import GOALS
from pigbench.agents.metrics import LossAndMetrics, combine
from pigbench.agents.sarsa import Sarsa
from pigbench.errors import require
from pigbench.shapes import Array


@dataclass(frozen=True)
class FlowCloneConfig(AgentConfig):
    """Hyperparameters of the flow clone; the defaults are SHARSA's."""

    layer_norm: bool = True  # layer normalisation in the vector field (and in values)
    flow_steps: int = 10  # M: Euler steps of the flow

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, lambda x: x >= 1, "at least 1", "flow_steps")


Config = TypeVar("Config", bound=FlowCloneConfig)


class FlowClone(Agent[Config]):
    """A flow of actions given state and goal."""

    supported_goals = tuple(GOALS)

    @cached_property
    def actor(self) -> FlowPolicy:
        """The flow of actions."""
        config = self.config
        return FlowPolicy(
            config.actor_hidden_sizes, self.action_size, config.layer_norm, config.flow_steps
        )

    def init(self, key: PRNGKeyArray) -> Params:
        """Parameters of "actor"."""
        actor_key, _ = jax.random.split(key)
        return {"actor": self.actor.init(actor_key, **self.inputs)}

    def loss(
        self, params: Params, target_params: Params, batch: Batch, key: PRNGKeyArray
    ) -> LossAndMetrics:
        """The flow-matching loss."""
        return self.actor.loss(
            params["actor"],
            observations=batch.observations,
            goals=self.as_goals(batch.actor_goals),
            samples=batch.actions,
            key=key,
        )

    def act(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        goal: Float[Array, "observation"],
        key: PRNGKeyArray,
    ) -> Float[Array, "action"]:
        """A sample of the flow, clipped to [-1, 1]."""
        return self.draw(params, observation, goal, key, count=1)[0]

    def draw(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        goal: Float[Array, "observation"],
        key: PRNGKeyArray,
        *,
        count: int,
    ) -> Float[Array, "candidate action"]:
        """`count` samples of the flow, clipped to [-1, 1]."""
        goal = self.as_goals(goal)
        drawn = self.actor.sample(
            params["actor"], observation=observation, goal=goal, count=count, key=key
        )
        return jnp.clip(drawn, -1, 1)


@dataclass(frozen=True)
class BestOfFlowConfig(FlowCloneConfig, TargetConfig):
    """Hyperparameters of the best of several samples; the defaults are DSHARSA's."""

    candidates: int = 32  # actions drawn, of which the critic picks the best

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, lambda x: x >= 2, "at least 2", "candidates")


class BestOfFlow(FlowClone[BestOfFlowConfig]):
    """A flow of actions, of whose samples a SARSA critic picks the best."""

    target_networks = ("critic",)

    @cached_property
    def values(self) -> Sarsa:
        """The critic of actions."""
        return Sarsa(self.config.value_hidden_sizes, self.config.layer_norm)

    def init(self, key: PRNGKeyArray) -> Params:
        """Parameters of "actor", "critic" and "value"."""
        _, values_key = jax.random.split(key)
        return super().init(key) | self.values.init(values_key, **self.critic_inputs)

    def loss(
        self, params: Params, target_params: Params, batch: Batch, key: PRNGKeyArray
    ) -> LossAndMetrics:
        """The flow-matching loss and the critic's losses, which train disjoint networks."""
        values = self.values.loss(
            params,
            target_params,
            observations=batch.observations,
            actions=batch.actions,
            goals=self.as_goals(batch.value_goals),
            next_observations=batch.next_observations,
            success=batch.value_success,
            # At the goal, no step is left.
            discounts=jnp.where(batch.value_success, 1, self.config.discount),
        )
        return combine(super().loss(params, target_params, batch, key), values)

    def act(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        goal: Float[Array, "observation"],
        key: PRNGKeyArray,
    ) -> Float[Array, "action"]:
        """The best of `candidates` samples of the flow, clipped to [-1, 1]."""
        count = self.config.candidates
        return self.values.best(
            params,
            observation=observation,
            goal=self.as_goals(goal),
            candidates=self.draw(params, observation, goal, key, count=count),
        )
