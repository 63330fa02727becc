"""Loss terms as functions on arrays: one value an example, batch axes last, no reduction."""

import jax
import jax.numpy as jnp
import numpy as np

MAX_AWR_WEIGHT = 100.0


def td_target(
    rewards: jax.Array, continuations: jax.Array, next_values: jax.Array, *, discount: float
) -> jax.Array:
    """One-step backup r + discount * m * V(s'), with m = 0 where nothing follows, else 1."""
    return rewards + discount * continuations * next_values


def goal_td_target(
    success: jax.Array, next_values: jax.Array, *, discount: float, goal_reward: float = 0.0
) -> jax.Array:
    """The backup of `goal_reward` at the goal, where nothing follows, and of 1 less elsewhere.

    `success` is 1 at the goal, else 0. By default a step costs 1 until the goal is reached.
    """
    rewards = success - 1 + goal_reward
    return td_target(rewards, 1 - success, next_values, discount=discount)


def expectile(advantages: jax.Array, errors: jax.Array, *, level: float) -> jax.Array:
    """Squared `errors`, weighted by `level` where the advantage is not negative, else by 1 - level.

    With `errors` as the advantages this is expectile regression; giving them apart decides the side
    once for all members of an ensemble (the paper's L_2^iota(A, e), Eq. low_ivl_loss).
    """
    return jnp.where(advantages < 0, 1 - level, level) * errors**2


def implicit_value(
    values: jax.Array,
    target_values: jax.Array,
    target_next_values: jax.Array,
    success: jax.Array,
    *,
    discount: float,
    level: float,
    goal_reward: float = 0.0,
) -> jax.Array:
    """Implicit value learning, Eq. low_ivl_loss: members (M, B) and `success` (B,) to (B,).

    Each member follows its own target copy; all share the expectile's side, which is that of the
    advantage of the least backup over the targets' mean.
    """
    backups = goal_td_target(
        success, target_next_values, discount=discount, goal_reward=goal_reward
    )
    advantages = backups.min(axis=0) - target_values.mean(axis=0)
    return expectile(advantages, backups - values, level=level).sum(axis=0)


def unit_gaussian_log_prob(actions: jax.Array, means: jax.Array) -> jax.Array:
    """log N(a; mean, I), summed over the last axis: (..., a) -> (...)."""
    return -0.5 * jnp.sum((actions - means) ** 2 + np.log(2 * np.pi), axis=-1)


def awr(advantages: jax.Array, log_probs: jax.Array, *, temperature: float) -> jax.Array:
    """Advantage-weighted regression, -min(exp(temperature * A), 100) log pi(a | s, g).

    The weights carry no gradient (Eq. low_actor_loss of the paper's appendix).
    """
    weights = jnp.minimum(jnp.exp(temperature * advantages), MAX_AWR_WEIGHT)
    return -jax.lax.stop_gradient(weights) * log_probs


def push_apart(distances: jax.Array, *, offset: float, beta: float) -> jax.Array:
    """QRL's push, softplus of sharpness `beta` on offset - d: falls with d, less so past `offset`.

    Wang et al. (2023), "Optimal Goal-Reaching Reinforcement Learning via Quasimetric Learning".
    """
    return jax.nn.softplus(beta * (offset - distances)) / beta


def hinge(excess: jax.Array) -> jax.Array:
    """The square of what is above 0: the penalty of the constraint `excess` <= 0."""
    return jax.nn.relu(excess) ** 2


def lagrangian(log_multiplier: jax.Array, violation: jax.Array, *, margin: float) -> jax.Array:
    """lambda (violation - margin), to be minimised in the violation and maximised in lambda.

    Gradient descent does both, for lambda's own gradient has its sign turned; the loss' value
    means nothing. A step on log(lambda) changes lambda by a share of itself, and keeps it positive.
    """
    multiplier = jnp.exp(log_multiplier)
    fixed_multiplier, fixed_violation = jax.lax.stop_gradient((multiplier, violation))
    return fixed_multiplier * violation - multiplier * (fixed_violation - margin)
