"""GCIQL: goal-conditioned implicit Q-learning with a DDPG+BC actor.

Kostrikov et al. (2022), "Offline Reinforcement Learning with Implicit Q-Learning", with goals. The
actor's BC weight is OGBench's for the cube environments.
"""

from dataclasses import dataclass
from functools import cached_property

import jax
import jax.numpy as jnp
from jaxtyping import Float, PRNGKeyArray, PyTree, Scalar

from pigbench.agents import actors, losses
from pigbench.agents.actors import PolicyAgent
from pigbench.agents.agent import Params
from pigbench.agents.batch import Batch
from pigbench.agents.config import PolicyConfig, TargetConfig
from pigbench.agents.metrics import LossAndMetrics, combine, describe
from pigbench.agents.networks import Critic, Value, apply, apply_ensemble, init_ensemble
from pigbench.errors import require
from pigbench.shapes import Array


@dataclass(frozen=True)
class GCIQLConfig(PolicyConfig, TargetConfig):
    """Hyperparameters of GCIQL."""

    expectile: float = 0.9
    bc_weight: float = 1.0  # alpha of DDPG+BC

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, lambda x: 0 < x < 1, "between 0 and 1, both excluded", "expectile")
        require(self, lambda x: x >= 0, "at least 0", "bc_weight")


class GCIQL(PolicyAgent[GCIQLConfig]):
    """One value V(s, g), two critics Q_i(s, a, g) with target copies, and a Gaussian policy."""

    target_networks = ("critic",)
    members = 2

    @cached_property
    def value(self) -> Value:
        """The network of V."""
        return Value(self.config.value_hidden_sizes, layer_norm=self.config.layer_norm)

    @cached_property
    def critic(self) -> Critic:
        """The network of one Q_i."""
        return Critic(self.config.value_hidden_sizes, layer_norm=self.config.layer_norm)

    def init(self, key: PRNGKeyArray) -> Params:
        """Parameters of "value", "critic" (two members, stacked) and "policy"."""
        value_key, critic_key, policy_key = jax.random.split(key, 3)
        return {
            "value": self.value.init(value_key, **self.inputs),
            "critic": init_ensemble(self.critic, critic_key, self.members, **self.critic_inputs),
            "policy": self.init_policy(policy_key),
        }

    def loss(
        self, params: Params, target_params: Params, batch: Batch, key: PRNGKeyArray
    ) -> LossAndMetrics:
        """Value, critic and actor losses, which train disjoint networks. `key` is unused."""
        return combine(
            self._value_loss(params, target_params, batch),
            self._critic_loss(params, batch),
            self._actor_loss(params, batch),
        )

    def state_value(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        goal: Float[Array, "observation"],
    ) -> Scalar:
        """V(s, g)."""
        return self._values(params["value"], observation, goal)

    def _value_loss(self, params: Params, target_params: Params, batch: Batch) -> LossAndMetrics:
        values = self._values(params["value"], batch.observations, batch.value_goals)
        critics = self._critics(
            target_params["critic"], batch.observations, batch.actions, batch.value_goals
        )
        advantages = critics.min(axis=0) - values
        loss = losses.expectile(advantages, advantages, level=self.config.expectile).mean()
        return loss, describe("value", values) | {"value/loss": loss}

    def _critic_loss(self, params: Params, batch: Batch) -> LossAndMetrics:
        next_values = self._values(params["value"], batch.next_observations, batch.value_goals)
        backups = jax.lax.stop_gradient(
            losses.goal_td_target(batch.value_success, next_values, discount=self.config.discount)
        )
        critics = self._critics(
            params["critic"], batch.observations, batch.actions, batch.value_goals
        )
        loss = jnp.sum((backups - critics) ** 2, axis=0).mean()
        return loss, describe("critic", critics) | {"critic/loss": loss}

    def _actor_loss(self, params: Params, batch: Batch) -> LossAndMetrics:
        members = jax.lax.stop_gradient(params["critic"])

        def critic(actions: Float[Array, "batch action"]) -> Float[Array, "batch"]:
            return self._critics(members, batch.observations, actions, batch.actor_goals).min(
                axis=0
            )

        means = self.means(params, batch.observations, batch.actor_goals)
        return actors.ddpg_bc(means, batch.actions, critic, bc_weight=self.config.bc_weight)

    def _values(
        self,
        value: PyTree,
        observations: Float[Array, "*batch observation"],
        goals: Float[Array, "*batch observation"],
    ) -> Float[Array, "*batch"]:
        return apply(self.value, value, observations=observations, goals=self.as_goals(goals))

    def _critics(
        self,
        members: PyTree,
        observations: Float[Array, "batch observation"],
        actions: Float[Array, "batch action"],
        goals: Float[Array, "batch observation"],
    ) -> Float[Array, "member batch"]:
        """Q_i(s, a, g)."""
        goals = self.as_goals(goals)
        return apply_ensemble(
            self.critic, members, observations=observations, actions=actions, goals=goals
        )
