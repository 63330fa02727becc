"""The parts of an observation that networks see, each a group of its terms.

A low level may see only part of a state, and an agent only part of a goal.
"""

from collections.abc import Mapping

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from pigbench.agents.statistics import Statistics
from pigbench.errors import UserError, lookup
from pigbench.layout import Layout
from pigbench.shapes import Array

REPRESENTATIONS: Mapping[str, str] = {
    "full": "all",
    "joints_contacts": "joints_contacts",
    "proprio": "robot",
}
"""The group of an observation's terms that each representation keeps."""


class Representation:
    """x of s: the terms that representation `name` of `table` keeps, in the observation's order.

    The attribute `layout` is that of x. With the `statistics` of observations, x is standardised to
    mean 0 and deviation 1 in the data.

    Raises `UserError` if there is no such representation, or if it keeps none of `layout`'s terms.
    """

    def __init__(
        self,
        name: str,
        layout: Layout,
        statistics: Statistics | None = None,
        table: Mapping[str, str] = REPRESENTATIONS,
    ) -> None:
        self._parts = layout.group(lookup("representation", table, name))
        if not self._parts:
            raise UserError(
                f"representation {name!r} keeps no term of the observation, "
                f"whose terms are {', '.join(layout)}: choose another"
            )
        self.layout = layout.subset(self._parts)
        self._statistics = statistics and statistics.select(self._parts)

    def __call__(
        self, observations: Float[Array, "*batch observation"]
    ) -> Float[Array, "*batch x"]:
        """x of s."""
        kept = jnp.concatenate([observations[..., part] for part in self._parts.values()], -1)
        if self._statistics is None:
            return kept
        return (kept - self._statistics.mean) / self._statistics.deviation

    def restore(self, x: Float[Array, "*batch x"]) -> Float[Array, "*batch x"]:
        """The kept terms in the observation's own units."""
        if self._statistics is None:
            return x
        return x * self._statistics.deviation + self._statistics.mean

    def statistics(self, of: Statistics | None) -> Statistics | None:
        """The statistics of x, from those of observations."""
        if self._statistics is not None:
            return Statistics.standard(self.size)
        return of and of.select(self._parts)

    @property
    def units(self) -> Float[np.ndarray, "x"] | float:
        """The size of one unit of each coordinate of x in the observation's units."""
        return 1.0 if self._statistics is None else self._statistics.deviation

    @property
    def size(self) -> int:
        """The length of x."""
        return self.layout.size
