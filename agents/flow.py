"""Flow policies: a vector field that carries Gaussian noise to conditional samples.

Flow matching on straight paths (Lipman et al., 2023; Liu et al., 2023), as in "High-level flow
actor loss" and the inference algorithm of the paper's appendix.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import flax.linen as nn
import jax
import jax.numpy as jnp
from jaxtyping import Float, Int, PRNGKeyArray, PyTree

from pigbench.agents.metrics import LossAndMetrics
from pigbench.agents.networks import MLP, apply
from pigbench.shapes import Array

Velocity = Callable[[Float[Array, "*batch n"], Float[Array, "*batch"]], Float[Array, "*batch n"]]
"""v(x, t)."""


def matching_loss(
    velocity: Velocity, samples: Float[Array, "batch n"], key: PRNGKeyArray
) -> Float[Array, "batch"]:
    """||v(x_t, t) - (x_1 - x_0)||^2 at x_t = (1 - t) x_0 + t x_1, of samples x_1.

    `key` draws the noise x_0 from N(0, I) and the times t from U[0, 1).
    """
    noise_key, time_key = jax.random.split(key)
    noise = jax.random.normal(noise_key, samples.shape)
    times = jax.random.uniform(time_key, samples.shape[:-1])
    points = (1 - times)[..., None] * noise + times[..., None] * samples
    return jnp.sum((velocity(points, times) - (samples - noise)) ** 2, axis=-1)


def integrate(
    velocity: Velocity, noise: Float[Array, "*batch n"], *, steps: int
) -> Float[Array, "*batch n"]:
    """The points that `noise` reaches after `steps` Euler steps from t = 0 to 1."""

    def step(m: Int[Array, ""], points: Float[Array, "*batch n"]) -> Float[Array, "*batch n"]:
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
        self,
        *,
        observations: Float[Array, "*batch observation"],
        goals: Float[Array, "*batch goal"],
        points: Float[Array, "*batch n"],
        times: Float[Array, "*batch"],
    ) -> Float[Array, "*batch n"]:
        """The velocity at time t at a point x of length `output_size`."""
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

    def init(
        self,
        key: PRNGKeyArray,
        *,
        observations: Float[Array, "*batch observation"],
        goals: Float[Array, "*batch goal"],
    ) -> PyTree:
        """Initial parameters, for inputs of these sizes."""
        times = jnp.zeros(observations.shape[:-1])
        points = jnp.zeros((*times.shape, self.output_size))
        return self.field.init(
            key, observations=observations, goals=goals, points=points, times=times
        )

    def loss(
        self,
        params: PyTree,
        *,
        observations: Float[Array, "batch observation"],
        goals: Float[Array, "batch goal"],
        samples: Float[Array, "batch n"],
        key: PRNGKeyArray,
    ) -> LossAndMetrics:
        """The mean matching loss on `samples` given s and g."""
        velocity = self._velocity(params, observations, goals)
        loss = matching_loss(velocity, samples, key).mean()
        return loss, {"actor/loss": loss}

    def sample(
        self,
        params: PyTree,
        *,
        observation: Float[Array, "observation"],
        goal: Float[Array, "goal"],
        count: int,
        key: PRNGKeyArray,
    ) -> Float[Array, "candidate n"]:
        """N = `count` independent samples."""
        observations, goals = (
            jnp.broadcast_to(one, (count, *one.shape)) for one in (observation, goal)
        )
        noise = jax.random.normal(key, (count, self.output_size))
        return integrate(self._velocity(params, observations, goals), noise, steps=self.steps)

    def _velocity(
        self,
        params: PyTree,
        observations: Float[Array, "*batch observation"],
        goals: Float[Array, "*batch goal"],
    ) -> Velocity:
        def velocity(
            points: Float[Array, "*batch n"], times: Float[Array, "*batch"]
        ) -> Float[Array, "*batch n"]:
            return apply(
                self.field,
                params,
                observations=observations,
                goals=goals,
                points=points,
                times=times,
            )

        return velocity
