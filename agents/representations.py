"""What networks see of an observation, chosen by the names of its terms.

A low level sees less of states than they have, and an agent may see less of goals.
"""

from collections.abc import Callable, Mapping
from functools import cached_property

import jax
import jax.numpy as jnp
import numpy as np

from pigbench.agents.statistics import Statistics
from pigbench.errors import UserError, lookup

JOINTS_CONTACTS = frozenset({"joint_pos", "joint_vel", "gripper_opening", "gripper_contact"})


def is_object(term: str) -> bool:
    """Does a term of the observation tell of a cube, and not of the robot?"""
    return term.startswith("cube_")


def is_position(term: str) -> bool:
    """Is a term of the observation the position of a cube?"""
    return is_object(term) and term.endswith("_pos")


REPRESENTATIONS: Mapping[str, Callable[[str], bool]] = {
    "full": lambda term: True,
    "joints_contacts": lambda term: term in JOINTS_CONTACTS,
    "proprio": lambda term: not is_object(term),
}
"""Which terms of an observation a representation keeps."""

GOALS: Mapping[str, Callable[[str], bool]] = {
    "state": lambda term: True,
    "cubes": is_position,
}
"""Which terms of a goal's observation a policy is told: all, or where the cubes are to be, as in
OGBench's `-oraclerep` environments. Whether a goal is reached does not depend on it."""


class Representation:
    """x of s: the terms that representation `name` of a table keeps, in the observation's order.

    With the `statistics` of observations, x is standardised: of mean 0 and deviation 1 in the data.

    Raises `UserError` if there is no such representation, or if it keeps none of `layout`'s terms.
    """

    def __init__(
        self,
        name: str,
        layout: Mapping[str, slice],
        statistics: Statistics | None = None,
        table: Mapping[str, Callable[[str], bool]] = REPRESENTATIONS,
    ) -> None:
        keeps = lookup("representation", table, name)
        self._slices = {term: part for term, part in layout.items() if keeps(term)}
        if not self._slices:
            raise UserError(
                f"representation {name!r} keeps no term of the observation, "
                f"whose terms are {', '.join(layout) or 'not named'}: choose another"
            )
        self._statistics = statistics and statistics.select(self._slices)

    def __call__(self, observations: jax.Array) -> jax.Array:
        """(..., observation_size) to (..., size)."""
        kept = jnp.concatenate([observations[..., part] for part in self._slices.values()], -1)
        if self._statistics is None:
            return kept
        return (kept - self._statistics.mean) / self._statistics.deviation

    def restore(self, x: jax.Array) -> jax.Array:
        """The kept terms as they are in an observation: (..., size) to the same."""
        if self._statistics is None:
            return x
        return x * self._statistics.deviation + self._statistics.mean

    def lift(self, directions: jax.Array, *, like: jax.Array) -> jax.Array:
        """Directions in x as such in observations, which are `like`: (..., size) to (..., o)."""
        scaled, lifted = directions * self.units, jnp.zeros_like(like)
        for term, part in self._slices.items():
            lifted = lifted.at[..., part].set(scaled[..., self.layout[term]])
        return lifted

    def statistics(self, of: Statistics | None) -> Statistics | None:
        """Those of x, from those of observations."""
        if self._statistics is not None:
            return Statistics.standard(self.size)
        return of and of.select(self._slices)

    @property
    def units(self) -> np.ndarray | float:
        """What a unit of each coordinate of x is in the observation's own, (size,)."""
        return 1.0 if self._statistics is None else self._statistics.deviation

    @cached_property
    def layout(self) -> Mapping[str, slice]:
        """Where the kept terms lie in x."""
        layout, stop = {}, 0
        for term, part in self._slices.items():
            start, stop = stop, stop + part.stop - part.start
            layout[term] = slice(start, stop)
        return layout

    @property
    def size(self) -> int:
        """Numbers in x."""
        return max(part.stop for part in self.layout.values())
