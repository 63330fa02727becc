"""Loss terms as functions of arrays: one value per example, no reduction."""

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float, Scalar

from pigbench.shapes import Array

MAX_AWR_WEIGHT = 100.0


def goal_td_target(
    success: Float[Array, "batch"],
    next_values: Float[Array, "*member batch"],
    *,
    discount: float,
    goal_reward: float = 0.0,
) -> Float[Array, "*member batch"]:
    """The one-step backup r + discount V(s'), or r alone at the goal, which is terminal.

    The reward r is `goal_reward` at the goal and 1 less elsewhere; `success` is 1 at the goal, else
    0. By default, each step costs 1 until the goal is reached.
    """
    rewards = success - 1 + goal_reward
    return rewards + discount * (1 - success) * next_values


def expectile(
    advantages: Float[Array, "batch"], errors: Float[Array, "*member batch"], *, level: float
) -> Float[Array, "*member batch"]:
    """Squared `errors`, weighted by `level` where the advantage is not negative, else by 1 - level.

    If the advantages are the errors, this is expectile regression. Separate advantages decide the
    side once for all members of an ensemble: L_2^iota(A, e) in "Low-level HJB-regularized value
    loss" of the paper's appendix.
    """
    return jnp.where(advantages < 0, 1 - level, level) * errors**2


def implicit_value(
    values: Float[Array, "member batch"],
    target_values: Float[Array, "member batch"],
    target_next_values: Float[Array, "member batch"],
    success: Float[Array, "batch"],
    *,
    discount: float,
    level: float,
    goal_reward: float = 0.0,
) -> Float[Array, "batch"]:
    """Implicit value learning.

    Each member regresses to the backup of its own target copy. All share the expectile's side,
    given by the advantage of the smallest backup over the targets' mean. This is the term L_IVL in
    "Low-level HJB-regularized value loss" of the paper's appendix.
    """
    backups = goal_td_target(
        success, target_next_values, discount=discount, goal_reward=goal_reward
    )
    advantages = backups.min(axis=0) - target_values.mean(axis=0)
    return expectile(advantages, backups - values, level=level).sum(axis=0)


def unit_gaussian_log_prob(
    actions: Float[Array, "*batch action"], means: Float[Array, "*batch action"]
) -> Float[Array, "*batch"]:
    """log N(a; mean, I)."""
    return -0.5 * jnp.sum((actions - means) ** 2 + np.log(2 * np.pi), axis=-1)


def awr(
    advantages: Float[Array, "*batch"], log_probs: Float[Array, "*batch"], *, temperature: float
) -> Float[Array, "*batch"]:
    """Advantage-weighted regression, -min(exp(temperature * A), 100) log pi(a | s, g).

    The weights carry no gradient ("Low-level actor loss" in the paper's appendix).
    """
    weights = jnp.minimum(jnp.exp(temperature * advantages), MAX_AWR_WEIGHT)
    return -jax.lax.stop_gradient(weights) * log_probs


def push_apart(
    distances: Float[Array, "*batch"], *, offset: float, beta: float
) -> Float[Array, "*batch"]:
    """QRL's push on distances: softplus of offset - d with sharpness `beta`; fades past `offset`.

    Wang et al. (2023), "Optimal Goal-Reaching Reinforcement Learning via Quasimetric Learning".
    """
    return jax.nn.softplus(beta * (offset - distances)) / beta


def hinge(excess: Float[Array, "*batch"]) -> Float[Array, "*batch"]:
    """The squared positive part: the penalty for the constraint `excess` <= 0."""
    return jax.nn.relu(excess) ** 2


def lagrangian(log_multiplier: Scalar, violation: Scalar, *, margin: float) -> Scalar:
    """lambda (violation - margin), to be minimised in the violation and maximised in lambda.

    Gradient descent does both, because the sign of lambda's gradient is flipped; the value of the
    loss is meaningless. A step on log(lambda) changes lambda in proportion and keeps it positive.
    """
    multiplier = jnp.exp(log_multiplier)
    fixed_multiplier, fixed_violation = jax.lax.stop_gradient((multiplier, violation))
    return fixed_multiplier * violation - multiplier * (fixed_violation - margin)
