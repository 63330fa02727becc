"""Flow policies: a vector field that carries Gaussian noise to conditional samples.

Flow matching on straight paths (Lipman et al., 2023; Liu et al., 2023), as in "High-level flow
actor loss" and the inference algorithm of the paper's appendix.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import flax.linen as nn
import jax
import jax.numpy as jnp

from pigbench.agents.agent import Metrics
from pigbench.agents.networks import MLP

Velocity = Callable[[jax.Array, jax.Array], jax.Array]
"""v(x, t): points (..., n) and times (...,) to velocities (..., n)."""


def matching_loss(velocity: Velocity, samples: jax.Array, key: jax.Array) -> jax.Array:
    """||v(x_t, t) - (x_1 - x_0)||^2 at x_t = (1 - t) x_0 + t x_1: samples x_1 (B, n) to (B,).

    `key` draws the noise x_0 from N(0, I) and the times t from U[0, 1).
    """
    noise_key, time_key = jax.random.split(key)
    noise = jax.random.normal(noise_key, samples.shape)
    times = jax.random.uniform(time_key, samples.shape[:-1])
    points = (1 - times)[..., None] * noise + times[..., None] * samples
    return jnp.sum((velocity(points, times) - (samples - noise)) ** 2, axis=-1)


def integrate(velocity: Velocity, noise: jax.Array, *, steps: int) -> jax.Array:
    """The points (..., n) that `noise` reaches after `steps` Euler steps from t = 0 to 1."""

    def step(m: jax.Array, points: jax.Array) -> jax.Array:
        times = jnp.full(points.shape[:-1], m / steps, points.dtype)
        return points + velocity(points, times) / steps

    return jax.lax.fori_loop(0, steps, step, noise)


class VectorField(nn.Module):
    """v(s, g, x, t)."""

    hidden_sizes: Sequence[int]
    output_size: int
    layer_norm: bool

    @nn.compact
    def __call__(
        self, *, observations: jax.Array, goals: jax.Array, points: jax.Array, times: jax.Array
    ) -> jax.Array:
        """(..., o), (..., g), (..., n) and (...,) to (..., n), with n = `output_size`."""
        inputs = jnp.concatenate([observations, goals, points, times[..., None]], axis=-1)
        return MLP(self.hidden_sizes, self.output_size, layer_norm=self.layer_norm)(inputs)


@dataclass(frozen=True)
class FlowPolicy:
    """A sampler of x in R^n, n = `output_size`, given s and g, with `steps` integration steps."""

    hidden_sizes: tuple[int, ...]
    output_size: int
    layer_norm: bool
    steps: int

    @cached_property
    def field(self) -> VectorField:
        """The vector field's network."""
        return VectorField(self.hidden_sizes, self.output_size, self.layer_norm)

    def init(self, key: jax.Array, *, observations: jax.Array, goals: jax.Array) -> Any:
        """Initial parameters, for inputs of these shapes, (B, o) and (B, g)."""
        times = jnp.zeros(observations.shape[:-1])
        points = jnp.zeros((*times.shape, self.output_size))
        return self.field.init(
            key, observations=observations, goals=goals, points=points, times=times
        )

    def loss(
        self,
        params: Any,
        *,
        observations: jax.Array,
        goals: jax.Array,
        samples: jax.Array,
        key: jax.Array,
    ) -> tuple[jax.Array, Metrics]:
        """The mean matching loss on `samples` (B, n) given s (B, o) and g (B, g)."""
        velocity = self._velocity(params, observations, goals)
        loss = matching_loss(velocity, samples, key).mean()
        return loss, {"actor/loss": loss}

    def sample(
        self,
        params: Any,
        *,
        observation: jax.Array,
        goal: jax.Array,
        count: int,
        key: jax.Array,
    ) -> jax.Array:
        """`count` independent samples: s (o,) and g (g,) to (count, n)."""
        observations, goals = (
            jnp.broadcast_to(one, (count, *one.shape)) for one in (observation, goal)
        )
        noise = jax.random.normal(key, (count, self.output_size))
        return integrate(self._velocity(params, observations, goals), noise, steps=self.steps)

    def _velocity(self, params: Any, observations: jax.Array, goals: jax.Array) -> Velocity:
        def velocity(points: jax.Array, times: jax.Array) -> Any:
            return self.field.apply(
                params, observations=observations, goals=goals, points=points, times=times
            )

        return velocity
