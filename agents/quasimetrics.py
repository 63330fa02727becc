"""Quasimetrics: learned distances that satisfy the triangle inequality but may be asymmetric.

A network embeds states, and a formula gives the distance between two embeddings. It is 0 from a
point to itself, never negative, and at most the distance through any third point.
"""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import flax.linen as nn
import jax
import jax.numpy as jnp
from jaxtyping import Float

from pigbench.agents.networks import MLP
from pigbench.agents.norms import safe_norm
from pigbench.shapes import Array


def interval_lengths(
    starts: Float[Array, "*#batch n"], ends: Float[Array, "*#batch n"]
) -> Float[Array, "..."]:
    """The length of the union of the n intervals [x_i, max(x_i, y_i)].

    It is the sum of the ends at which a covered stretch closes, less the starts at which one opens.
    These are found by comparing all pairs, which is elementwise and has no derivative.
    """
    lower, upper = jnp.broadcast_arrays(starts, jnp.maximum(starts, ends))
    my_lower, my_upper = lower[..., :, None], upper[..., :, None]
    its_lower, its_upper = lower[..., None, :], upper[..., None, :]
    earlier = jnp.tri(lower.shape[-1], k=-1, dtype=bool)  # of equal ones, the first counts
    covered_below = (its_lower < my_lower) & (my_lower <= its_upper)
    covered_above = (its_lower <= my_upper) & (my_upper < its_upper)
    opens = ~jnp.any(covered_below | ((its_lower == my_lower) & earlier), axis=-1)
    closes = ~jnp.any(covered_above | ((its_upper == my_upper) & earlier), axis=-1)
    return jnp.sum(jnp.where(closes, upper, 0) - jnp.where(opens, lower, 0), axis=-1)


class Quasimetric(nn.Module):
    """d(s, g) between embeddings of size n = `latent_size`; subclasses define `distance`."""

    divisor: ClassVar[int]
    """What n must be a multiple of."""

    hidden_sizes: Sequence[int]
    latent_size: int
    layer_norm: bool

    def setup(self) -> None:
        """Create the embedding's network."""
        self.encoder = MLP(self.hidden_sizes, self.latent_size, layer_norm=self.layer_norm)

    def __call__(
        self,
        *,
        observations: Float[Array, "*#batch observation"],
        goals: Float[Array, "*#batch observation"],
    ) -> Float[Array, "..."]:
        """d(s, g)."""
        return self.distance(
            starts=self.encode(observations=observations), ends=self.encode(observations=goals)
        )

    def encode(
        self, *, observations: Float[Array, "*batch observation"]
    ) -> Float[Array, "*batch n"]:
        """The embedding."""
        return self.encoder(observations)

    def distance(
        self, *, starts: Float[Array, "*#batch n"], ends: Float[Array, "*#batch n"]
    ) -> Float[Array, "..."]:
        """From one embedding to another."""
        raise NotImplementedError


class IQE(Quasimetric):
    """Interval quasimetric embedding, with components of `component_size` intervals each.

    A component's distance is the length of the union of its intervals [x_i, y_i]; the total is a
    learned mixture of the components' maximum and mean (Wang and Isola, 2022, "Improved
    Representation of Asymmetrical Distances with Interval Quasimetric Embeddings").
    """

    component_size: int = 8
    divisor = component_size

    def setup(self) -> None:
        """Create the embedding's network and the mixture's logit."""
        super().setup()
        self.mixture = self.param("mixture", nn.initializers.zeros, ())

    def distance(
        self, *, starts: Float[Array, "*#batch n"], ends: Float[Array, "*#batch n"]
    ) -> Float[Array, "..."]:
        """As in `Quasimetric`."""
        lengths = interval_lengths(self._components(starts), self._components(ends))
        share = jax.nn.sigmoid(self.mixture)
        return share * lengths.mean(axis=-1) + (1 - share) * lengths.max(axis=-1)

    def _components(
        self, latents: Float[Array, "*batch n"]
    ) -> Float[Array, "*batch component interval"]:
        return latents.reshape(*latents.shape[:-1], -1, self.component_size)


class MRN(Quasimetric):
    """Metric residual network: a metric on half of the embedding plus an asymmetric residual.

    ||x - y|| on one half plus max_i relu(x_i - y_i) on the other (Liu et al., 2023, "Metric
    Residual Networks for Sample Efficient Goal-Conditioned Reinforcement Learning").
    """

    divisor = 2

    def distance(
        self, *, starts: Float[Array, "*#batch n"], ends: Float[Array, "*#batch n"]
    ) -> Float[Array, "..."]:
        """As in `Quasimetric`."""
        symmetric, asymmetric = jnp.split(starts - ends, 2, axis=-1)
        return safe_norm(symmetric) + jax.nn.relu(asymmetric).max(axis=-1)


QUASIMETRICS: Mapping[str, type[Quasimetric]] = {"iqe": IQE, "mrn": MRN}
"""Quasimetrics by name."""
