"""GCIVL: goal-conditioned implicit value learning with an advantage-weighted actor.

Its value loss may carry a physics-informed regulariser; that field alone tells GCIVL, Eik-GCIVL
and HJB-GCIVL apart. Losses follow the paper's appendix (Eqs. low_ivl_loss, low_value_loss and
low_actor_loss), with the full state in place of the low-level one.
"""

from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, cast

import jax
import jax.numpy as jnp

from pigbench.agents import losses
from pigbench.agents.agent import Agent, Metrics, Params
from pigbench.agents.batch import Batch
from pigbench.agents.config import AgentConfig, require
from pigbench.agents.networks import Policy, Value
from pigbench.agents.regularizers import Regularizer


@dataclass(frozen=True)
class GCIVLConfig(AgentConfig):
    """Hyper-parameters of GCIVL; defaults are the paper's."""

    expectile: float = 0.9  # iota
    temperature: float = 10.0  # alpha of the actor's weights
    regularizer: Regularizer = field(default_factory=Regularizer)

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, lambda x: 0 < x < 1, "between 0 and 1, both excluded", "expectile")
        require(self, lambda x: x >= 0, "at least 0", "temperature")


class GCIVL(Agent[GCIVLConfig]):
    """Two values V_i(s, g) with target copies, and a Gaussian policy of standard deviation 1."""

    target_networks = ("value",)
    members = 2

    @cached_property
    def value(self) -> Value:
        """The network of one member."""
        return Value(self.config.value_hidden_sizes, layer_norm=self.config.layer_norm)

    @cached_property
    def policy(self) -> Policy:
        """The network of the policy's mean."""
        return Policy(self.config.actor_hidden_sizes, self.action_size)

    def init(self, key: jax.Array) -> Params:
        """Parameters of "value" (two members, stacked) and of "policy"."""
        value_key, policy_key = jax.random.split(key)
        states = jnp.zeros((1, self.observation_size))
        init_member = partial(self.value.init, observations=states, goals=states)
        return {
            "value": jax.vmap(init_member)(jax.random.split(value_key, self.members)),
            "policy": self.policy.init(policy_key, observations=states, goals=states),
        }

    def loss(
        self, params: Params, target_params: Params, batch: Batch, key: jax.Array
    ) -> tuple[jax.Array, Metrics]:
        """Value loss plus actor loss; they train disjoint networks. Draws nothing from `key`."""
        value_loss, value_metrics = self._value_loss(params["value"], target_params["value"], batch)
        actor_loss, actor_metrics = self._actor_loss(params["policy"], params["value"], batch)
        return value_loss + actor_loss, value_metrics | actor_metrics

    def act(
        self, params: Params, observations: jax.Array, goals: jax.Array, key: jax.Array
    ) -> jax.Array:
        """The policy's mean, clipped to [-1, 1]. Draws nothing from `key`."""
        means = self._policy(params["policy"], observations=observations, goals=goals)
        return jnp.clip(means, -1, 1)

    def _value_loss(self, members: Any, targets: Any, batch: Batch) -> tuple[jax.Array, Metrics]:
        config = self.config

        def regularized(member: Any) -> tuple[jax.Array, jax.Array]:
            return config.regularizer(
                lambda states: self._value(member, observations=states, goals=batch.value_goals),
                batch.observations,
                batch.next_observations,
            )

        values, residuals = jax.vmap(regularized)(members)
        target_values, next_values = self._transition_values(targets, batch, batch.value_goals)

        # The reward is -1 a step until the goal; there it is 0, and nothing follows.
        backups = losses.td_target(
            batch.value_success - 1, 1 - batch.value_success, next_values, discount=config.discount
        )
        advantages = backups.min(axis=0) - target_values.mean(axis=0)
        td_losses = losses.expectile(advantages, backups - values, level=config.expectile)

        td_loss = td_losses.sum(axis=0).mean()
        regularization = config.regularizer.weight * residuals.sum(axis=0).mean()
        return td_loss + regularization, {
            "value/td_loss": td_loss,
            "value/regularization": regularization,
            "value/residual": residuals.mean(),
            "value/mean": values.mean(),
            "value/min": values.min(),
            "value/max": values.max(),
        }

    def _actor_loss(self, policy: Any, members: Any, batch: Batch) -> tuple[jax.Array, Metrics]:
        values, next_values = self._transition_values(
            jax.lax.stop_gradient(members), batch, batch.actor_goals
        )
        advantages = next_values.mean(axis=0) - values.mean(axis=0)
        means = self._policy(policy, observations=batch.observations, goals=batch.actor_goals)
        log_probs = losses.unit_gaussian_log_prob(batch.actions, means)
        loss = losses.awr(advantages, log_probs, temperature=self.config.temperature).mean()
        return loss, {
            "actor/loss": loss,
            "actor/advantage": advantages.mean(),
            "actor/mse": jnp.mean((batch.actions - means) ** 2),
        }

    def _transition_values(
        self, members: Any, batch: Batch, goals: jax.Array
    ) -> tuple[jax.Array, jax.Array]:
        """V_i(s, g) and V_i(s', g), each (members, B), in one call."""
        states = jnp.stack([batch.observations, batch.next_observations])
        goals = jnp.broadcast_to(goals, states.shape)
        values = jax.vmap(partial(self._value, observations=states, goals=goals))(members)
        return values[:, 0], values[:, 1]

    def _value(self, member: Any, *, observations: jax.Array, goals: jax.Array) -> jax.Array:
        return cast(jax.Array, self.value.apply(member, observations=observations, goals=goals))

    def _policy(self, policy: Any, *, observations: jax.Array, goals: jax.Array) -> jax.Array:
        return cast(jax.Array, self.policy.apply(policy, observations=observations, goals=goals))
