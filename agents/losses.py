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


def expectile(advantages: jax.Array, errors: jax.Array, *, level: float) -> jax.Array:
    """Squared `errors`, weighted by `level` where the advantage is not negative, else by 1 - level.

    With `errors` as the advantages this is expectile regression; giving them apart decides the side
    once for all members of an ensemble (the paper's L_2^iota(A, e), Eq. low_ivl_loss).
    """
    return jnp.where(advantages < 0, 1 - level, level) * errors**2


def unit_gaussian_log_prob(actions: jax.Array, means: jax.Array) -> jax.Array:
    """log N(a; mean, I), summed over the last axis: (..., a) -> (...)."""
    return -0.5 * jnp.sum((actions - means) ** 2 + np.log(2 * np.pi), axis=-1)


def awr(advantages: jax.Array, log_probs: jax.Array, *, temperature: float) -> jax.Array:
    """Advantage-weighted regression, -min(exp(temperature * A), 100) log pi(a | s, g).

    The weights carry no gradient (Eq. low_actor_loss of the paper's appendix).
    """
    weights = jnp.minimum(jnp.exp(temperature * advantages), MAX_AWR_WEIGHT)
    return -jax.lax.stop_gradient(weights) * log_probs
