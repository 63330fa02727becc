"""Evaluation tasks, and those of the environments that come with pigbench.

A table maps each environment to its tasks; OGBench's environments have OGBench's five tasks in its
order. A place is (x, y) in metres, followed by the level in a stack if that is not 0.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from pigbench.envs.cubes import CUBE_HALF_SIZE

START_JITTER = 0.01  # metres by which start positions are shifted at most in x and y

Place = tuple[float, ...]  # (x, y) on the floor, or (x, y, level)


@dataclass(frozen=True)
class Task:
    """A start and a goal for each cube; starts are shifted by up to `jitter` metres in x and y."""

    name: str
    start: tuple[Place, ...]
    goal: tuple[Place, ...]
    jitter: tuple[float, float] = (START_JITTER, START_JITTER)

    @property
    def start_xyz(self) -> Float[np.ndarray, "cube 3"]:
        """Cube positions at the start, in metres."""
        return positions(self.start)

    @property
    def goal_xyz(self) -> Float[np.ndarray, "cube 3"]:
        """Cube positions at the goal, in metres."""
        return positions(self.goal)


def positions(places: tuple[Place, ...]) -> Float[np.ndarray, "cube 3"]:
    """The centres of cubes at these places, in metres."""
    levels = [place[2] if len(place) > 2 else 0 for place in places]
    heights = [CUBE_HALF_SIZE * (1 + 2 * level) for level in levels]
    return np.array([(*place[:2], z) for place, z in zip(places, heights, strict=True)])


TASKS: dict[str, tuple[Task, ...]] = {
    "cube-single": (
        Task("task1_horizontal", ((0.425, 0.1),), ((0.425, -0.1),)),
        Task("task2_vertical1", ((0.35, 0),), ((0.5, 0),)),
        Task("task3_vertical2", ((0.5, 0),), ((0.35, 0),)),
        Task("task4_diagonal1", ((0.35, -0.2),), ((0.5, 0.2),)),
        Task("task5_diagonal2", ((0.35, 0.2),), ((0.5, -0.2),)),
    ),
    # The paper's robot: from anywhere in the cubes' region to the centre.
    "cube-centre": (Task("task1_centre", ((0.425, 0),), ((0.425, 0),), jitter=(0.125, 0.3)),),
    "cube-double": (
        Task("task1_single_pnp", ((0.425, 0), (0.425, -0.1)), ((0.425, 0), (0.425, 0.1))),
        Task("task2_double_pnp1", ((0.35, -0.1), (0.5, -0.1)), ((0.35, 0.1), (0.5, 0.1))),
        Task("task3_double_pnp2", ((0.35, 0), (0.5, 0)), ((0.425, -0.2), (0.425, 0.2))),
        Task("task4_swap", ((0.425, -0.1), (0.425, 0.1)), ((0.425, 0.1), (0.425, -0.1))),
        Task("task5_stack", ((0.425, -0.2), (0.425, 0.2)), ((0.425, 0), (0.425, 0, 1))),
    ),
    "cube-triple": (
        Task(
            "task1_single_pnp",
            ((0.35, -0.1), (0.35, 0.1), (0.5, -0.1)),
            ((0.35, -0.1), (0.35, 0.1), (0.5, 0.1)),
        ),
        Task(
            "task2_triple_pnp",
            ((0.35, -0.2), (0.35, 0), (0.35, 0.2)),
            ((0.5, 0), (0.5, 0.2), (0.5, -0.2)),
        ),
        Task(
            "task3_pnp_from_stack",
            ((0.425, 0.2), (0.425, 0.2, 1), (0.425, 0.2, 2)),
            ((0.35, -0.1), (0.5, -0.2), (0.5, 0)),
        ),
        Task(
            "task4_cycle",
            ((0.35, 0), (0.5, -0.1), (0.5, 0.1)),
            ((0.5, -0.1), (0.5, 0.1), (0.35, 0)),
        ),
        Task(
            "task5_stack",
            ((0.35, -0.1), (0.5, -0.2), (0.5, 0)),
            ((0.425, 0.2), (0.425, 0.2, 1), (0.425, 0.2, 2)),
        ),
    ),
    "cube-quadruple": (
        Task(
            "task1_double_pnp",
            ((0.35, -0.1), (0.35, 0.1), (0.5, -0.1), (0.5, 0.1)),
            ((0.35, -0.25), (0.35, 0.1), (0.5, -0.1), (0.5, 0.25)),
        ),
        Task(
            "task2_quadruple_pnp",
            ((0.325, -0.2), (0.325, 0.2), (0.525, -0.2), (0.525, 0.2)),
            ((0.375, 0.1), (0.475, 0.1), (0.375, -0.1), (0.475, -0.1)),
        ),
        Task(
            "task3_pnp_from_square",
            ((0.425, -0.02), (0.425, 0.02), (0.425, -0.02, 1), (0.425, 0.02, 1)),
            ((0.525, -0.2), (0.325, 0.2), (0.325, -0.2), (0.525, 0.2)),
        ),
        Task(
            "task4_cycle",
            ((0.525, -0.1), (0.525, 0.1), (0.325, 0.1), (0.325, -0.1)),
            ((0.525, 0.1), (0.325, 0.1), (0.325, -0.1), (0.525, -0.1)),
        ),
        Task(
            "task5_stack",
            ((0.5, -0.05), (0.5, -0.2), (0.35, -0.2), (0.35, -0.05)),
            ((0.425, 0.2), (0.425, 0.2, 1), (0.425, 0.2, 2), (0.425, 0.2, 3)),
        ),
    ),
    "cube-octuple": (
        Task(
            "task1_quadruple_pnp",
            (
                (0.325, -0.15),
                (0.425, -0.15),
                (0.425, -0.05),
                (0.525, -0.05),
                (0.325, 0.05),
                (0.425, 0.05),
                (0.425, 0.15),
                (0.525, 0.15),
            ),
            (
                (0.525, 0.05),
                (0.425, -0.15),
                (0.425, -0.05),
                (0.325, 0.15),
                (0.525, -0.15),
                (0.425, 0.05),
                (0.425, 0.15),
                (0.325, -0.05),
            ),
        ),
        Task(
            "task2_octuple_pnp1",
            (
                (0.4, -0.15),
                (0.4, -0.05),
                (0.4, 0.05),
                (0.4, 0.15),
                (0.45, -0.15),
                (0.45, -0.05),
                (0.45, 0.05),
                (0.45, 0.15),
            ),
            (
                (0.525, 0.2),
                (0.525, 0),
                (0.525, -0.2),
                (0.425, -0.2),
                (0.325, -0.2),
                (0.325, 0),
                (0.325, 0.2),
                (0.425, 0.2),
            ),
        ),
        Task(
            "task3_octuple_pnp2",
            (
                (0.32, -0.15),
                (0.32, 0.05),
                (0.39, -0.05),
                (0.39, 0.15),
                (0.46, -0.15),
                (0.46, 0.05),
                (0.53, -0.05),
                (0.53, 0.15),
            ),
            (
                (0.32, 0.15),
                (0.46, 0.15),
                (0.39, 0.05),
                (0.53, 0.05),
                (0.32, -0.05),
                (0.46, -0.05),
                (0.39, -0.15),
                (0.53, -0.15),
            ),
        ),
        Task(
            "task4_stack1",
            (
                (0.4, -0.025),
                (0.4, -0.025, 1),
                (0.4, 0.025),
                (0.4, 0.025, 1),
                (0.45, -0.025),
                (0.45, -0.025, 1),
                (0.45, 0.025),
                (0.45, 0.025, 1),
            ),
            (
                (0.525, 0.05),
                (0.525, -0.05),
                (0.425, -0.15, 1),
                (0.425, -0.15),
                (0.425, 0.15, 1),
                (0.425, 0.15),
                (0.325, -0.05),
                (0.325, 0.05),
            ),
        ),
        Task(
            "task5_stack2",
            (
                (0.5, 0.2, 1),
                (0.5, 0.2),
                (0.5, -0.2, 1),
                (0.5, -0.2),
                (0.35, -0.2, 1),
                (0.35, -0.2),
                (0.35, 0.2, 1),
                (0.35, 0.2),
            ),
            (
                (0.325, 0),
                (0.325, 0, 1),
                (0.425, 0.2),
                (0.425, 0.2, 1),
                (0.525, 0),
                (0.525, 0, 1),
                (0.425, -0.2),
                (0.425, -0.2, 1),
            ),
        ),
    ),
}
