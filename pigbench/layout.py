"""The layout of observations: named terms, in order, and the groups to which they belong.

Environments make layouts, data sets store them, and agents look up coordinates in them. Every layer
of the package may import this module; it imports none of them.
"""

import itertools
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

_OBJECT = re.compile(r"[a-z]+_[0-9]+_.+")


def _is_object(term: str) -> bool:
    return _OBJECT.fullmatch(term) is not None


GROUPS: Mapping[str, Callable[[str], bool]] = {
    "all": lambda term: True,
    "robot": lambda term: not _is_object(term),
    "joints_contacts": lambda term: term.startswith(("joint_", "gripper_")),
    "objects": _is_object,
    "object_positions": lambda term: _is_object(term) and term.endswith("_pos"),
    "velocities": lambda term: term.endswith("_vel"),
}
"""Whether a group has a term, by the term's name.

A name is PART_QUANTITY; the parts of objects are numbered (`cube_0_pos`), the robot's are not
(`joint_vel`). Stored layouts thus have their groups without naming them.
"""


@dataclass(frozen=True)
class Layout(Mapping[str, slice]):
    """The terms of an observation; as a mapping, from a term's name to its slice.

    Attributes:
        terms: (name, size) of each term, in order.
    """

    terms: tuple[tuple[str, int], ...]

    @classmethod
    def of(cls, sizes: Mapping[str, int]) -> "Layout":
        """The layout of terms with these sizes, in this order."""
        return cls(tuple(sizes.items()))

    @property
    def size(self) -> int:
        """The length of an observation."""
        return sum(size for _, size in self.terms)

    def group(self, name: str) -> dict[str, slice]:
        """The terms of the group `name` of `GROUPS` and their slices, in order."""
        has = GROUPS[name]
        return {term: part for term, part in self.items() if has(term)}

    def subset(self, names: Iterable[str]) -> "Layout":
        """The layout of observations that consist of the terms `names` alone, in the same order."""
        kept = set(names)
        return Layout(tuple(term for term in self.terms if term[0] in kept))

    @cached_property
    def _slices(self) -> dict[str, slice]:
        stops = itertools.accumulate(size for _, size in self.terms)
        return {
            name: slice(stop - size, stop)
            for (name, size), stop in zip(self.terms, stops, strict=True)
        }

    def __getitem__(self, name: str) -> slice:
        return self._slices[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._slices)

    def __len__(self) -> int:
        return len(self._slices)


@dataclass(frozen=True)
class Space:
    """What an agent observes, and the length of the actions with which it answers."""

    layout: Layout
    action_size: int
