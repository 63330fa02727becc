"""The low level of SHARSA and DSHARSA: behaviour cloning with a flow.

Park et al. (2025), "Horizon Reduction Makes RL Scalable". Their high level is in
`flow_hierarchy.py`.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Float, PRNGKeyArray

from pigbench.agents.agent import Agent, Params
from pigbench.agents.batch import Batch
from pigbench.agents.config import AgentConfig
from pigbench.agents.flow import FlowPolicy
from pigbench.agents.metrics import LossAndMetrics, combine
from pigbench.agents.representations import GOALS
from pigbench.agents.sarsa import Sarsa
from pigbench.errors import require
from pigbench.layout import Space
from pigbench.shapes import Array


@dataclass(frozen=True)
class FlowCloneConfig(AgentConfig):
    """Hyperparameters of the flow clone; the defaults are SHARSA's."""

    flow_steps: int = 10
    candidates: int = 1  # actions drawn; if several, a critic picks the best

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, lambda x: x >= 1, "at least 1", "flow_steps", "candidates")


class FlowClone(Agent[FlowCloneConfig]):
    """A flow of actions given state and goal; a SARSA critic picks the best of several samples."""

    supported_goals = tuple(GOALS)

    def __init__(self, config: FlowCloneConfig, space: Space, **data: Any) -> None:
        super().__init__(config, space, **data)
        self.has_critic = config.candidates > 1
        self.target_networks = ("critic",) if self.has_critic else ()

    @cached_property
    def actor(self) -> FlowPolicy:
        """The flow of actions."""
        config = self.config
        return FlowPolicy(
            config.actor_hidden_sizes, self.action_size, config.layer_norm, config.flow_steps
        )

    @cached_property
    def values(self) -> Sarsa:
        """The critic of actions."""
        return Sarsa(self.config.value_hidden_sizes, self.config.layer_norm)

    def init(self, key: PRNGKeyArray) -> Params:
        """Parameters of "actor" and, with a critic, "critic" and "value"."""
        actor_key, values_key = jax.random.split(key)
        params = {"actor": self.actor.init(actor_key, **self.inputs)}
        if self.has_critic:
            params |= self.values.init(values_key, **self.critic_inputs)
        return params

    def loss(
        self, params: Params, target_params: Params, batch: Batch, key: PRNGKeyArray
    ) -> LossAndMetrics:
        """The flow-matching loss and, with a critic, its losses, which train disjoint networks."""
        actor = self.actor.loss(
            params["actor"],
            observations=batch.observations,
            goals=self.as_goals(batch.actor_goals),
            samples=batch.actions,
            key=key,
        )
        if not self.has_critic:
            return actor
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
        return combine(actor, values)

    def act(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        goal: Float[Array, "observation"],
        key: PRNGKeyArray,
    ) -> Float[Array, "action"]:
        """The best of `candidates` samples of the flow, clipped to [-1, 1]."""
        inputs = {"observation": observation, "goal": self.as_goals(goal)}
        count = self.config.candidates
        drawn = self.actor.sample(params["actor"], **inputs, count=count, key=key)
        actions = jnp.clip(drawn, -1, 1)
        if not self.has_critic:
            return actions[0]
        return self.values.best(params, **inputs, candidates=actions)
