"""The parts of an observation that networks see, selected by the names of its terms.

A low level may see only part of a state, and an agent only part of a goal.
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
    """Whether a term of the observation describes a cube, not the robot."""
    return term.startswith("cube_")


def is_position(term: str) -> bool:
    """Whether a term of the observation is the position of a cube."""
    return is_object(term) and term.endswith("_pos")


REPRESENTATIONS: Mapping[str, Callable[[str], bool]] = {
    "full": lambda term: True,
    "joints_contacts": lambda term: term in JOINTS_CONTACTS,
    "proprio": lambda term: not is_object(term),
}
"""The terms of an observation that each representation keeps."""

GOALS: Mapping[str, Callable[[str], bool]] = {
    "state": lambda term: True,
    "cubes": is_position,
}
"""The terms of a goal's observation that networks see: all, or the cubes' positions, as in
OGBench's `-oraclerep` environments. The criterion of success does not depend on this."""


class Representation:
    """x of s: the terms that representation `name` of `table` keeps, in the observation's order.

    With the `statistics` of observations, x is standardised to mean 0 and deviation 1 in the data.

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
        """The kept terms in the observation's own units: (..., size) to (..., size)."""
        if self._statistics is None:
            return x
        return x * self._statistics.deviation + self._statistics.mean

    def statistics(self, of: Statistics | None) -> Statistics | None:
        """The statistics of x, from those of observations."""
        if self._statistics is not None:
            return Statistics.standard(self.size)
        return of and of.select(self._slices)

    @property
    def units(self) -> np.ndarray | float:
        """The size of one unit of each coordinate of x in the observation's units, (size,)."""
        return 1.0 if self._statistics is None else self._statistics.deviation

    @cached_property
    def layout(self) -> Mapping[str, slice]:
        """The slices of the kept terms in x."""
        layout, stop = {}, 0
        for term, part in self._slices.items():
            start, stop = stop, stop + part.stop - part.start
            layout[term] = slice(start, stop)
        return layout

    @property
    def size(self) -> int:
        """The length of x."""
        return max(part.stop for part in self.layout.values())
