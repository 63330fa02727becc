"""The quality of an episode with one cube, judged by observations, which robot logs have too."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Real

from pigbench.envs.cubes import CUBE_HALF_SIZE
from pigbench.envs.units import CONTROL_STEP, metres
from pigbench.errors import UserError, lookup, require
from pigbench.layout import Layout

FELT = 0.1
"""Contact from which the pad counts as feeling something."""
LYING = 0.015
"""Metres by which the centre of a cube on the table may appear too high: a choice, several times
the errors of its estimate (in `envs.reality`, 2 mm of noise and 3 mm of bias)."""
IN_AIR = 0.03
"""Height in metres above the table from which a released cube falls."""


@dataclass(frozen=True)
class Limits:
    """The limits within which an episode is kept.

    Jerk and rows are a choice: the paper names no limits. Together, the limits keep 72 % of the
    rows of 100 simulated episodes (`results/robot`); the paper kept 60,000 of 80,000 transitions.
    """

    within: float = 0.05
    """Metres from the goal within which a cube counts as brought there."""
    max_jerk: float = 70.0
    """Largest root mean square of the joints' jerk, rad/s^3."""
    min_rows: int = 40
    """Rows of the shortest episode."""
    max_rows: int = 270
    """Rows of the longest episode."""
    max_drops: int = 0
    """Largest number of times that the cube is lost in the air."""

    def __post_init__(self) -> None:
        require(self, lambda x: x >= 0, "at least 0", *vars(self))
        if self.min_rows > self.max_rows:
            raise UserError(
                f"min_rows is {self.min_rows}: it must be at most max_rows, which is "
                f"{self.max_rows}"
            )


@dataclass(frozen=True)
class JudgedColumns:
    """An episode's columns; positions in metres."""

    joint_vel: Float[np.ndarray, "row 6"]  # rad/s
    contact: Real[np.ndarray, "row"]
    cube: Float[np.ndarray, "row 3"]
    goal: Float[np.ndarray, "3"]


@dataclass(frozen=True)
class Criterion:
    """A measure of an episode, whether it is good enough, and what that depends on.

    Attributes:
        fields: the fields of `Limits` that it looks at.
        limit: a description of these limits.
    """

    fields: tuple[str, ...]
    measure: Callable[[JudgedColumns, Limits], float]
    good: Callable[[float, Limits], bool]
    limit: Callable[[Limits], str]


def closest(episode: JudgedColumns, limits: Limits) -> float:
    """Least distance in metres from the goal at which the cube lay untouched on the table.

    Infinity if it never lay away from the goal. The robot may thus have brought the cube to the
    goal or away from it.
    """
    low = episode.cube[:, 2] < CUBE_HALF_SIZE + LYING
    distance = np.linalg.norm(episode.cube - episode.goal, axis=-1)[low & (episode.contact < FELT)]
    if not len(distance) or distance.max() <= limits.within:
        return np.inf
    return float(distance.min())


def jerk(episode: JudgedColumns, limits: Limits) -> float:
    """Root mean square of the joints' jerk, rad/s^3."""
    change = np.diff(episode.joint_vel, n=2, axis=0) / CONTROL_STEP**2
    return float(np.sqrt(np.mean(change**2))) if len(change) else 0.0


def drops(episode: JudgedColumns, limits: Limits) -> float:
    """How often the pad lost contact while the cube was in the air."""
    felt = episode.contact >= FELT
    high = episode.cube[1:, 2] > CUBE_HALF_SIZE + IN_AIR
    return float(np.sum(felt[:-1] & ~felt[1:] & high))


CRITERIA: Mapping[str, Criterion] = {
    "success": Criterion(
        ("within",),
        closest,
        lambda value, limits: value <= limits.within,
        lambda limits: f"brought to within {limits.within:g} m of the goal, or away",
    ),
    "jerk": Criterion(
        ("max_jerk",),
        jerk,
        lambda value, limits: value <= limits.max_jerk,
        lambda limits: f"at most {limits.max_jerk:g} rad/s^3",
    ),
    "length": Criterion(
        ("min_rows", "max_rows"),
        lambda episode, limits: float(len(episode.cube)),
        lambda value, limits: limits.min_rows <= value <= limits.max_rows,
        lambda limits: f"{limits.min_rows:,} to {limits.max_rows:,} rows",
    ),
    "drops": Criterion(
        ("max_drops",),
        drops,
        lambda value, limits: value <= limits.max_drops,
        lambda limits: f"at most {limits.max_drops}",
    ),
}
"""The criteria by name; this table determines what is measured and what is good enough."""


def check(criteria: Collection[str], limits: Limits) -> None:
    """Raise UserError for an unknown criterion, or a limit that was set for none of them."""
    for name in criteria:
        lookup("criterion", CRITERIA, name)
    usual = Limits()
    for name, criterion in CRITERIA.items():
        for field in criterion.fields:
            if name not in criteria and getattr(limits, field) != getattr(usual, field):
                raise UserError(f"{field} has no effect without criterion {name!r}: leave it out")


def episode(
    observations: Float[np.ndarray, "row observation"], layout: Layout, goal: Float[np.ndarray, "3"]
) -> JudgedColumns:
    """An episode's columns, of its observations and the goal.

    Raises UserError if the observations have none of them.
    """
    needed = ("joint_vel", "gripper_contact", "cube_0_pos")
    missing = [name for name in needed if name not in layout]
    if missing:
        raise UserError(f"observations tell no {', '.join(missing)}, by which episodes are judged")
    return JudgedColumns(
        joint_vel=observations[:, layout["joint_vel"]],
        contact=observations[:, layout["gripper_contact"]][:, 0],
        cube=metres(observations[:, layout["cube_0_pos"]]),
        goal=goal,
    )


def measure(one: JudgedColumns, limits: Limits) -> dict[str, float]:
    """Each criterion's measure of an episode."""
    return {name: criterion.measure(one, limits) for name, criterion in CRITERIA.items()}
