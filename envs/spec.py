"""What distinguishes an environment from others with the same robot and table."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pigbench.envs import terms
from pigbench.envs.cubes import CUBE_HALF_SIZE, MAX_CUBES
from pigbench.envs.reality import Reality
from pigbench.envs.scripted import SCRIPTED
from pigbench.envs.tasks import START_JITTER, Place, Task, positions
from pigbench.envs.walls import WALLS
from pigbench.errors import UserError, lookup
from pigbench.names import check

SUCCESS_DISTANCE = 0.04  # metres from its target within which a cube is placed
_TOLERANCE = 1e-6  # metres by which cubes that touch may seem to overlap


@dataclass(frozen=True)
class EnvSpec:
    """All that distinguishes an environment from others with the same robot and table.

    Raises UserError if its parts do not fit together, or if there is no such policy or term.

    Attributes:
        episode_length: control steps after which an evaluation episode has failed.
        tasks: the evaluation tasks.
        success_distance: metres from its target within which a cube counts as placed.
        unobserved: terms that the observation lacks.
        reality: the imperfections of sensing and acting; None without any.
        policy: the scripted policy that collects data by default.
        stacking: range of the probability with which such a policy puts a cube on another; it is
            drawn uniformly, once per episode. By default OGBench's with eight cubes.
    """

    name: str
    num_cubes: int
    episode_length: int
    tasks: tuple[Task, ...]
    success_distance: float = SUCCESS_DISTANCE
    unobserved: frozenset[str] = frozenset()
    reality: Reality | None = None
    policy: str = "play"
    stacking: tuple[float, float] = (0.0, 0.35)

    def __post_init__(self) -> None:
        for holds, problem in self._requirements():
            if not holds:
                raise UserError(f"environment {self.name!r} {problem}")
        for task in self.tasks:
            check("a task", task.name)

    def _requirements(self) -> Iterator[tuple[bool, str]]:
        """What must hold, and what is wrong if it does not."""
        low, high = self.stacking
        most = lookup("policy", SCRIPTED, self.policy).most_cubes
        yield (
            1 <= self.num_cubes <= MAX_CUBES,
            f"has {self.num_cubes} cubes: there is room for 1 to {MAX_CUBES}",
        )
        yield bool(terms.layout(self.num_cubes, self.unobserved)), "observes nothing"
        yield (
            self.num_cubes <= most,
            f"has {self.num_cubes} cubes, and its policy {self.policy!r} moves no more than {most}",
        )
        yield (
            self.episode_length >= 1,
            f"has episodes of {self.episode_length} control steps: it must be at least 1",
        )
        yield bool(self.tasks), "has no tasks: it needs at least one"
        for task in self.tasks:
            starts, goals = len(task.start), len(task.goal)
            yield (
                starts == goals == self.num_cubes,
                f"has {self.num_cubes} cubes, but {task.name!r} places {starts} at the start and "
                f"{goals} at the goal",
            )
            for place in (*task.start, *task.goal):
                yield (
                    _is_on_table(place),
                    f"has a cube at {place} in {task.name!r}: a place is (x, y) in metres, "
                    f"{_INSIDE}, or (x, y, level) with a whole level in a stack",
                )
            for places in (task.start, task.goal):
                for one, other in itertools.combinations(places, 2):
                    yield (
                        not _overlap(one, other),
                        f"has cubes at {one} and at {other} in {task.name!r}: they are "
                        f"{2 * CUBE_HALF_SIZE:g} m wide, and must not overlap",
                    )
            shifts = f"shifts starts by up to {task.jitter} in {task.name!r}"
            yield (
                len(task.jitter) == 2 and all(0 <= shift < math.inf for shift in task.jitter),
                f"{shifts}: it must be (x, y) in metres, both at least 0",
            )
            for place in task.start:
                yield (
                    _is_inside(place, task.jitter),
                    f"{shifts}, which takes that at {place} off the table: a cube's place is "
                    f"{_INSIDE}",
                )
            if max(task.jitter) > START_JITTER:  # with OGBench's own, some of its cubes may touch
                for one, other in itertools.combinations(task.start, 2):
                    yield (
                        not _overlap(one, other, task.jitter),
                        f"{shifts}, so that cubes at {one} and at {other} may overlap: shift them "
                        "less, or place them farther apart",
                    )
        names = [task.name for task in self.tasks]
        for name in names:
            yield names.count(name) == 1, f"has two tasks named {name!r}: rename one"
        yield (
            0 < self.success_distance < math.inf,
            f"has cubes placed within {self.success_distance} m: it must be more than 0",
        )
        yield (
            0 <= low <= high <= 1,
            f"stacks with a probability from {low} to {high}: it must be a range within 0 to 1",
        )


def _extent(low: str, high: str, axis: int) -> tuple[float, float]:
    """Where the centre of a cube can be between two walls, in metres along an axis."""
    (near_size, near), (far_size, far) = WALLS[low], WALLS[high]
    least = near[axis] + near_size[axis] + CUBE_HALF_SIZE
    return least, far[axis] - far_size[axis] - CUBE_HALF_SIZE


_X, _Y = _extent("wall_near", "wall_far", 0), _extent("wall_right", "wall_left", 1)
_INSIDE = f"x from {_X[0]:g} to {_X[1]:g} and y from {_Y[0]:g} to {_Y[1]:g}"


def _is_on_table(place: Place) -> bool:
    if len(place) not in (2, 3):
        return False
    return _is_inside(place) and all(level in range(MAX_CUBES) for level in place[2:])


def _is_inside(place: Place, jitter: tuple[float, float] = (0.0, 0.0)) -> bool:
    """Whether a cube there, parallel to the axes, is between the walls however it is shifted."""
    return all(
        low - _TOLERANCE <= at - shift and at + shift <= high + _TOLERANCE
        for at, shift, (low, high) in zip(place, jitter, (_X, _Y), strict=False)
    )


def _overlap(one: Place, other: Place, jitter: tuple[float, float] = (0.0, 0.0)) -> bool:
    """Whether cubes there, parallel to the axes, can be inside one another if each is shifted."""
    apart = np.abs(np.subtract(*positions((one, other)))) - 2 * np.array([*jitter, 0.0])
    return bool((apart < 2 * CUBE_HALF_SIZE - _TOLERANCE).all())
