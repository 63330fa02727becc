"""HIQL: hierarchical implicit Q-learning (Park et al., 2023), with the conventions of OGBench.

One value trains two Gaussian policies: the high-level one picks a subgoal K steps ahead, in the
value's own representation of goals, and the low-level one acts towards it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import flax.linen as nn
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, PRNGKeyArray, Scalar

from pigbench.agents import actors, losses
from pigbench.agents.agent import Agent, Params
from pigbench.agents.batch import Batch, Sampling, SubgoalSampling
from pigbench.agents.config import PolicyConfig, TargetConfig
from pigbench.agents.goals import GOALS
from pigbench.agents.metrics import LossAndMetrics, add_prefix, combine, describe
from pigbench.agents.networks import MLP, Policy, Value, apply, apply_ensemble, init_ensemble
from pigbench.agents.norms import safe_norm
from pigbench.errors import require
from pigbench.shapes import Array


@dataclass(frozen=True)
class HIQLConfig(PolicyConfig, TargetConfig):
    """Hyperparameters of HIQL; the defaults of the fields below are OGBench's for cubes."""

    expectile: float = 0.7
    high_temperature: float = 3.0
    low_temperature: float = 3.0
    subgoal_steps: int = 10  # K: how many steps ahead subgoals are
    representation_size: int = 10

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, lambda x: 0 < x < 1, "between 0 and 1, both excluded", "expectile")
        require(self, lambda x: x >= 0, "at least 0", "high_temperature", "low_temperature")
        require(self, lambda x: x >= 1, "at least 1", "subgoal_steps", "representation_size")


def on_sphere(vectors: Float[Array, "*batch n"]) -> Float[Array, "*batch n"]:
    """Vectors scaled to length sqrt(n); the zero vector stays zero."""
    lengths = safe_norm(vectors)[..., None]
    return vectors * np.sqrt(vectors.shape[-1]) / jnp.where(lengths > 0, lengths, 1)


class GoalRepresentation(nn.Module):
    """phi(s, g), of length sqrt(n)."""

    hidden_sizes: Sequence[int]
    output_size: int
    layer_norm: bool

    @nn.compact
    def __call__(
        self,
        *,
        observations: Float[Array, "*batch observation"],
        goals: Float[Array, "*batch goal"],
    ) -> Float[Array, "*batch n"]:
        """The representation, of length `output_size`."""
        inputs = jnp.concatenate([observations, goals], axis=-1)
        features = MLP(self.hidden_sizes, self.output_size, layer_norm=self.layer_norm)(inputs)
        return on_sphere(features)


class HIQL(Agent[HIQLConfig]):
    """Two values V_i(s, phi(s, g)) with target copies, and one policy per level.

    phi has no target copy and is trained by the value loss only.
    """

    supported_goals = tuple(GOALS)

    target_networks = ("value",)
    members = 2

    @property
    def sampling(self) -> Sampling:
        """As for a flat agent, plus subgoals; both levels share the value and hence its goals."""
        flat = super().sampling
        subgoals = SubgoalSampling(self.config.subgoal_steps, None, flat.discount)
        return replace(flat, subgoals=subgoals)

    @cached_property
    def representation(self) -> GoalRepresentation:
        """The network phi."""
        config = self.config
        return GoalRepresentation(
            config.value_hidden_sizes, config.representation_size, config.layer_norm
        )

    @cached_property
    def value(self) -> Value:
        """The network of one ensemble member; its goals are representations."""
        return Value(self.config.value_hidden_sizes, layer_norm=self.config.layer_norm)

    @cached_property
    def high_policy(self) -> Policy:
        """The network from (s, g) to the mean of phi(s, subgoal)."""
        config = self.config
        return Policy(
            config.actor_hidden_sizes, config.representation_size, config.actor_layer_norm
        )

    @cached_property
    def low_policy(self) -> Policy:
        """The network from (s, phi(s, subgoal)) to the mean action."""
        config = self.config
        return Policy(config.actor_hidden_sizes, self.action_size, config.actor_layer_norm)

    def init(self, key: PRNGKeyArray) -> Params:
        """Parameters of "representation", "value" (stacked), "high_policy" and "low_policy"."""
        keys = jax.random.split(key, 4)
        represented: dict[str, Any] = self.inputs | {
            "goals": jnp.zeros(self.config.representation_size)
        }
        return {
            "representation": self.representation.init(keys[0], **self.inputs),
            "value": init_ensemble(self.value, keys[1], self.members, **represented),
            "high_policy": self.high_policy.init(keys[2], **self.inputs),
            "low_policy": self.low_policy.init(keys[3], **represented),
        }

    def loss(
        self, params: Params, target_params: Params, batch: Batch, key: PRNGKeyArray
    ) -> LossAndMetrics:
        """Value loss plus policy losses, which train disjoint networks. `key` is unused."""
        return combine(
            self._value_loss(params, target_params, batch),
            self._actor_loss(params, batch),
        )

    def act(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        goal: Float[Array, "observation"],
        key: PRNGKeyArray,
    ) -> Float[Array, "action"]:
        """The low-level mean given the high-level mean, clipped to [-1, 1]. `key` is unused."""
        subgoal = apply(
            self.high_policy,
            params["high_policy"],
            observations=observation,
            goals=self.as_goals(goal),
        )
        action = apply(
            self.low_policy,
            params["low_policy"],
            observations=observation,
            goals=on_sphere(subgoal),
        )
        return jnp.clip(action, -1, 1)

    def state_value(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        goal: Float[Array, "observation"],
    ) -> Scalar:
        """The mean of the members, given the goal's representation."""
        return self._values(params, observation, goal)[0].mean(axis=0)

    def _value_loss(self, params: Params, target_params: Params, batch: Batch) -> LossAndMetrics:
        values, _ = self._values(params, batch.observations, batch.value_goals)
        targets, _ = self._values(
            jax.lax.stop_gradient(params) | target_params,
            jnp.stack([batch.observations, batch.next_observations]),
            jnp.stack([batch.value_goals] * 2),
        )
        loss = losses.implicit_value(
            values,
            targets[:, 0],
            targets[:, 1],
            batch.value_success,
            discount=self.config.discount,
            level=self.config.expectile,
        ).mean()
        return loss, describe("value", values) | {"value/td_loss": loss}

    def _actor_loss(self, params: Params, batch: Batch) -> LossAndMetrics:
        subgoals = batch.required_subgoals
        fixed = jax.lax.stop_gradient(params)
        states, next_states = batch.observations, batch.next_observations
        values, represented = self._values(
            fixed,
            jnp.stack([states, next_states, states, subgoals.actor_subgoals]),
            jnp.stack([subgoals.low_actor_goals] * 2 + [batch.actor_goals] * 2),
        )
        low_value, low_next_value, high_value, high_next_value = values.mean(axis=0)
        low_means = apply(
            self.low_policy, params["low_policy"], observations=states, goals=represented[0]
        )
        low_loss, low_metrics = actors.awr(
            low_means,
            batch.actions,
            low_next_value - low_value,
            temperature=self.config.low_temperature,
        )
        high_means = apply(
            self.high_policy,
            params["high_policy"],
            observations=states,
            goals=self.as_goals(batch.actor_goals),
        )
        subgoal = apply(
            self.representation,
            fixed["representation"],
            observations=states,
            goals=self.as_goals(subgoals.actor_subgoals),
        )
        high_loss, high_metrics = actors.awr(
            high_means,
            subgoal,
            high_next_value - high_value,
            temperature=self.config.high_temperature,
        )
        return low_loss + high_loss, {
            **add_prefix("low_", low_metrics),
            **add_prefix("high_", high_metrics),
        }

    def _values(
        self,
        params: Params,
        observations: Float[Array, "*batch observation"],
        goals: Float[Array, "*batch observation"],
    ) -> tuple[Float[Array, "member *batch"], Float[Array, "*batch n"]]:
        """V_i(s, phi(s, g)), and phi(s, g)."""
        represented = apply(
            self.representation,
            params["representation"],
            observations=observations,
            goals=self.as_goals(goals),
        )
        values = apply_ensemble(
            self.value, params["value"], observations=observations, goals=represented
        )
        return values, represented
