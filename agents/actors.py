"""Agents that act with a single Gaussian policy, and the losses that train it.

The policy is pi(a | s, g) = N(mean(s, g), I). Every loss takes its means on a batch, and the
batch's actions.
"""

from collections.abc import Callable
from functools import cached_property
from typing import TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Float, PRNGKeyArray, PyTree, Scalar

from pigbench.agents import losses
from pigbench.agents.agent import Agent, Params
from pigbench.agents.config import PolicyConfig
from pigbench.agents.goals import GOALS
from pigbench.agents.metrics import LossAndMetrics, Metrics
from pigbench.agents.networks import Policy, apply
from pigbench.shapes import Array

Config = TypeVar("Config", bound=PolicyConfig)


class PolicyAgent(Agent[Config]):
    """An agent that acts with the mean of one policy, whose parameters are named "policy"."""

    supported_goals = tuple(GOALS)

    @cached_property
    def policy(self) -> Policy:
        """The network that outputs the policy's mean."""
        config = self.config
        return Policy(config.actor_hidden_sizes, self.action_size, config.actor_layer_norm)

    def init_policy(self, key: PRNGKeyArray) -> PyTree:
        """Initial parameters of the policy."""
        return self.policy.init(key, **self.inputs)

    def means(
        self,
        params: Params,
        observations: Float[Array, "*batch observation"],
        goals: Float[Array, "*batch observation"],
    ) -> Float[Array, "*batch action"]:
        """The policy's mean actions, unclipped."""
        goals = self.as_goals(goals)
        return apply(self.policy, params["policy"], observations=observations, goals=goals)

    def act(
        self,
        params: Params,
        observation: Float[Array, "observation"],
        goal: Float[Array, "observation"],
        key: PRNGKeyArray,
    ) -> Float[Array, "action"]:
        """The policy's mean, clipped to [-1, 1]. `key` is unused."""
        return jnp.clip(self.means(params, observation, goal), -1, 1)


def clone(
    means: Float[Array, "batch action"], actions: Float[Array, "batch action"]
) -> LossAndMetrics:
    """Behaviour cloning, -log pi(a | s, g)."""
    loss = -losses.unit_gaussian_log_prob(actions, means).mean()
    return loss, _metrics(loss, means, actions)


def awr(
    means: Float[Array, "batch action"],
    actions: Float[Array, "batch action"],
    advantages: Float[Array, "batch"],
    *,
    temperature: float,
) -> LossAndMetrics:
    """Advantage-weighted regression; `advantages` belong to `actions`."""
    log_probs = losses.unit_gaussian_log_prob(actions, means)
    loss = losses.awr(advantages, log_probs, temperature=temperature).mean()
    return loss, _metrics(loss, means, actions) | {"actor/advantage": advantages.mean()}


def ddpg_bc(
    means: Float[Array, "batch action"],
    actions: Float[Array, "batch action"],
    critic: Callable[[Float[Array, "batch action"]], Float[Array, "batch"]],
    *,
    bc_weight: float,
) -> LossAndMetrics:
    """DDPG+BC: the policy maximises `critic` and clones the batch's actions.

    The critic's values are divided by their mean magnitude, so that `bc_weight` has the same
    meaning at any scale (Fujimoto and Gu, 2021). `critic` should stop gradients to its parameters.
    """
    values = critic(jnp.clip(means, -1, 1))
    scale = jax.lax.stop_gradient(jnp.abs(values).mean() + 1e-6)
    log_probs = losses.unit_gaussian_log_prob(actions, means)
    loss = -values.mean() / scale - bc_weight * log_probs.mean()
    return loss, _metrics(loss, means, actions) | {"actor/critic": values.mean()}


def _metrics(
    loss: Scalar, means: Float[Array, "batch action"], actions: Float[Array, "batch action"]
) -> Metrics:
    return {"actor/loss": loss, "actor/mse": jnp.mean((actions - means) ** 2)}
