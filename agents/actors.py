"""Agents that act with a single Gaussian policy, and the losses that train it.

The policy is pi(a | s, g) = N(mean(s, g), I). Every loss takes its means on a batch, (B, a), and
the batch's actions, and returns a scalar and metrics.
"""

from collections.abc import Callable
from functools import cached_property
from typing import Any

import jax
import jax.numpy as jnp

from pigbench.agents import losses
from pigbench.agents.agent import Agent, Config, Metrics, Params
from pigbench.agents.networks import Policy
from pigbench.agents.representations import GOALS


class PolicyAgent(Agent[Config]):
    """An agent that acts with the mean of one policy, whose parameters are named "policy"."""

    goals = tuple(GOALS)

    @cached_property
    def policy(self) -> Policy:
        """The network that outputs the policy's mean."""
        config = self.config
        return Policy(config.actor_hidden_sizes, self.action_size, config.actor_layer_norm)

    def init_policy(self, key: jax.Array) -> Any:
        """Initial parameters of the policy."""
        return self.policy.init(key, **self.inputs)

    def means(self, params: Params, observations: jax.Array, goals: jax.Array) -> Any:
        """The policy's mean actions, (..., a), unclipped."""
        goals = self.as_goals(goals)
        return self.policy.apply(params["policy"], observations=observations, goals=goals)

    def act(
        self, params: Params, observation: jax.Array, goal: jax.Array, key: jax.Array
    ) -> jax.Array:
        """The policy's mean, clipped to [-1, 1]. `key` is unused."""
        return jnp.clip(self.means(params, observation, goal), -1, 1)


def clone(means: jax.Array, actions: jax.Array) -> tuple[jax.Array, Metrics]:
    """Behaviour cloning, -log pi(a | s, g)."""
    loss = -losses.unit_gaussian_log_prob(actions, means).mean()
    return loss, _metrics(loss, means, actions)


def awr(
    means: jax.Array, actions: jax.Array, advantages: jax.Array, *, temperature: float
) -> tuple[jax.Array, Metrics]:
    """Advantage-weighted regression; `advantages` (B,) belong to `actions`."""
    log_probs = losses.unit_gaussian_log_prob(actions, means)
    loss = losses.awr(advantages, log_probs, temperature=temperature).mean()
    return loss, _metrics(loss, means, actions) | {"actor/advantage": advantages.mean()}


def ddpg_bc(
    means: jax.Array,
    actions: jax.Array,
    critic: Callable[[jax.Array], jax.Array],
    *,
    bc_weight: float,
) -> tuple[jax.Array, Metrics]:
    """DDPG+BC: the policy maximises `critic`, (B, a) to (B,), and clones the batch's actions.

    The critic's values are divided by their mean magnitude, so that `bc_weight` has the same
    meaning at any scale (Fujimoto and Gu, 2021). `critic` should stop gradients to its parameters.
    """
    values = critic(jnp.clip(means, -1, 1))
    scale = jax.lax.stop_gradient(jnp.abs(values).mean() + 1e-6)
    log_probs = losses.unit_gaussian_log_prob(actions, means)
    loss = -values.mean() / scale - bc_weight * log_probs.mean()
    return loss, _metrics(loss, means, actions) | {"actor/critic": values.mean()}


def _metrics(loss: jax.Array, means: jax.Array, actions: jax.Array) -> Metrics:
    return {"actor/loss": loss, "actor/mse": jnp.mean((actions - means) ** 2)}
