"""Neural networks. Inputs are keyword-only, so that none is swapped for another unnoticed.

An ensemble is not a network of its own: its members' parameters are stacked along a leading axis,
and `jax.vmap` maps any function of one member's parameters over them.
"""

from collections.abc import Sequence

import flax.linen as nn
import jax
import jax.numpy as jnp


class MLP(nn.Module):
    """Hidden layers with GELU, then layer normalisation if asked; a linear output layer.

    Weights start uniform with variance scale / mean(fan in, fan out), the scale being
    `output_scale` in the last layer and 1 before; biases start at 0.
    """

    hidden_sizes: Sequence[int]
    output_size: int
    layer_norm: bool = False
    output_scale: float = 1.0

    @nn.compact
    def __call__(self, inputs: jax.Array) -> jax.Array:
        """(..., n) to (..., output_size)."""
        features = inputs
        for size in self.hidden_sizes:
            features = nn.gelu(_dense(size, scale=1.0)(features))
            if self.layer_norm:
                features = nn.LayerNorm()(features)
        return _dense(self.output_size, scale=self.output_scale)(features)


class Value(nn.Module):
    """V(s, g)."""

    hidden_sizes: Sequence[int]
    layer_norm: bool

    @nn.compact
    def __call__(self, *, observations: jax.Array, goals: jax.Array) -> jax.Array:
        """(..., o) and (..., o) to (...,)."""
        inputs = jnp.concatenate([observations, goals], axis=-1)
        return MLP(self.hidden_sizes, 1, layer_norm=self.layer_norm)(inputs)[..., 0]


class Policy(nn.Module):
    """The mean of pi(a | s, g), near zero at first; it is not squashed."""

    hidden_sizes: Sequence[int]
    action_size: int

    @nn.compact
    def __call__(self, *, observations: jax.Array, goals: jax.Array) -> jax.Array:
        """(..., o) and (..., o) to (..., action_size)."""
        inputs = jnp.concatenate([observations, goals], axis=-1)
        return MLP(self.hidden_sizes, self.action_size, output_scale=0.01)(inputs)


def _dense(size: int, *, scale: float) -> nn.Dense:
    return nn.Dense(size, kernel_init=nn.initializers.variance_scaling(scale, "fan_avg", "uniform"))
