"""Neural networks. Inputs are keyword-only, so that they cannot be swapped unnoticed.

An ensemble is not a network of its own: the parameters of its members are stacked along a leading
axis, and `jax.vmap` maps any function of one member's parameters over them.
"""

from collections.abc import Sequence
from typing import Any, cast

import flax.linen as nn
import jax
import jax.numpy as jnp
from jaxtyping import Float, PRNGKeyArray, PyTree

from pigbench.shapes import Array


class MLP(nn.Module):
    """Hidden layers with GELU, each optionally followed by layer normalisation; a linear output.

    Initial weights are uniform with variance scale / mean(fan in, fan out), where the scale is
    `output_scale` in the last layer and 1 elsewhere; biases start at 0.
    """

    hidden_sizes: Sequence[int]
    output_size: int
    layer_norm: bool = False
    output_scale: float = 1.0

    @nn.compact
    def __call__(self, inputs: Float[Array, "*batch m"]) -> Float[Array, "*batch n"]:
        """The outputs, n = `output_size` of them."""
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
    def __call__(
        self,
        *,
        observations: Float[Array, "*batch observation"],
        goals: Float[Array, "*batch goal"],
    ) -> Float[Array, "*batch"]:
        """The value of s for g."""
        inputs = jnp.concatenate([observations, goals], axis=-1)
        return MLP(self.hidden_sizes, 1, layer_norm=self.layer_norm)(inputs)[..., 0]


class Critic(nn.Module):
    """Q(s, a, g), where the action may be any choice made at s, such as a subgoal."""

    hidden_sizes: Sequence[int]
    layer_norm: bool

    @nn.compact
    def __call__(
        self,
        *,
        observations: Float[Array, "*batch observation"],
        actions: Float[Array, "*batch action"],
        goals: Float[Array, "*batch goal"],
    ) -> Float[Array, "*batch"]:
        """The value of a at s for g."""
        inputs = jnp.concatenate([observations, actions, goals], axis=-1)
        return MLP(self.hidden_sizes, 1, layer_norm=self.layer_norm)(inputs)[..., 0]


class BilinearCritic(nn.Module):
    """Separate embeddings phi(s, a) and psi(g), whose inner product is a critic."""

    hidden_sizes: Sequence[int]
    latent_size: int
    layer_norm: bool

    @nn.compact
    def __call__(
        self,
        *,
        observations: Float[Array, "*batch observation"],
        actions: Float[Array, "*batch action"],
        goals: Float[Array, "*batch goal"],
    ) -> tuple[Float[Array, "*batch n"], Float[Array, "*batch n"]]:
        """phi / sqrt(n) and psi, with n = `latent_size`."""
        inputs = jnp.concatenate([observations, actions], axis=-1)
        phi, psi = (
            MLP(self.hidden_sizes, self.latent_size, layer_norm=self.layer_norm, name=name)(side)
            for name, side in (("phi", inputs), ("psi", goals))
        )
        return phi / jnp.sqrt(self.latent_size), psi


class LatentDynamics(nn.Module):
    """The embedding of the next state, predicted as that of the current state plus a change."""

    hidden_sizes: Sequence[int]
    layer_norm: bool

    @nn.compact
    def __call__(
        self, *, latents: Float[Array, "*batch n"], actions: Float[Array, "*batch action"]
    ) -> Float[Array, "*batch n"]:
        """The embedding of the next state."""
        inputs = jnp.concatenate([latents, actions], axis=-1)
        size = latents.shape[-1]
        return latents + MLP(self.hidden_sizes, size, layer_norm=self.layer_norm)(inputs)


class Policy(nn.Module):
    """The mean of pi(a | s, g), close to 0 at initialisation and not squashed."""

    hidden_sizes: Sequence[int]
    action_size: int
    layer_norm: bool = False

    @nn.compact
    def __call__(
        self,
        *,
        observations: Float[Array, "*batch observation"],
        goals: Float[Array, "*batch goal"],
    ) -> Float[Array, "*batch action"]:
        """The mean action."""
        inputs = jnp.concatenate([observations, goals], axis=-1)
        network = MLP(
            self.hidden_sizes, self.action_size, layer_norm=self.layer_norm, output_scale=0.01
        )
        return network(inputs)


def apply(
    network: nn.Module, params: PyTree, *, method: str = "__call__", **inputs: Any
) -> Float[Array, "..."]:
    """The output of a network's method that has one."""
    return cast(Array, network.apply(params, method=method, **inputs))


def init_ensemble(network: nn.Module, key: PRNGKeyArray, members: int, **inputs: Any) -> PyTree:
    """The parameters of `members` independent copies of `network`, stacked."""
    return jax.vmap(lambda key: network.init(key, **inputs))(jax.random.split(key, members))


def apply_ensemble(network: nn.Module, ensemble: PyTree, **inputs: Any) -> Any:
    """Each member's output for the same inputs, stacked along a new leading axis."""
    return jax.vmap(lambda member: network.apply(member, **inputs))(ensemble)


def _dense(size: int, *, scale: float) -> nn.Dense:
    return nn.Dense(size, kernel_init=nn.initializers.variance_scaling(scale, "fan_avg", "uniform"))
