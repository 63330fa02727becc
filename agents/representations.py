"""What the low level of a hierarchy sees of an observation, chosen by the names of its terms."""

from collections.abc import Callable, Mapping
from functools import cached_property

import jax
import jax.numpy as jnp

from pigbench.errors import UserError, lookup

JOINTS_CONTACTS = frozenset({"joint_pos", "joint_vel", "gripper_opening", "gripper_contact"})

REPRESENTATIONS: Mapping[str, Callable[[str], bool]] = {
    "full": lambda term: True,
    "joints_contacts": lambda term: term in JOINTS_CONTACTS,
    "proprio": lambda term: not term.startswith("cube_"),
}
"""Which terms of an observation a representation keeps."""


class Representation:
    """x of s: the terms that the representation `name` keeps, in the observation's order.

    Raises `UserError` if there is no such representation, or if it keeps none of `layout`'s terms.
    """

    def __init__(self, name: str, layout: Mapping[str, slice]) -> None:
        keeps = lookup("representation", REPRESENTATIONS, name)
        self._slices = {term: part for term, part in layout.items() if keeps(term)}
        if not self._slices:
            raise UserError(
                f"representation {name!r} keeps no term of the observation, "
                f"whose terms are {', '.join(layout) or 'not named'}: choose another"
            )

    def __call__(self, observations: jax.Array) -> jax.Array:
        """(..., observation_size) to (..., size)."""
        return jnp.concatenate([observations[..., part] for part in self._slices.values()], -1)

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
