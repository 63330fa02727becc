"""Goals: what networks see of them, and where those of a batch come from. Without JAX."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from pigbench.errors import UserError

GOALS: Mapping[str, str] = {"state": "all", "cubes": "object_positions"}
"""The group of a goal's terms that networks see: all, or the cubes' positions, as in OGBench's
`-oraclerep` environments. The criterion of success does not depend on this."""


@dataclass(frozen=True)
class GoalMixture:
    """Where the goal of a transition comes from: three probabilities that sum to 1.

    `current` is the transition's own first state, `future` a later state of its episode, and
    `random` any state of the data set. With `geometric`, the number of steps to a future goal is
    geometric in the discount, clipped at the end of the episode; otherwise it is uniform over the
    rest of the episode.

    Raises `UserError` if a probability is outside [0, 1] or the sum is not 1.
    """

    current: float  # share of goals that are the transition's own first state
    future: float  # share of goals that are a later state of the same episode
    random: float  # share of goals that are any state of the data set
    geometric: bool  # draw the steps to a later state geometrically (discount), not uniformly

    def __post_init__(self) -> None:
        shares = (self.current, self.future, self.random)
        if not (all(0 <= share <= 1 for share in shares) and math.isclose(sum(shares), 1)):
            raise UserError(
                f"goal mixture (current, future, random) is {shares}: "
                "it must be three probabilities that sum to 1"
            )


ACTOR_GOALS = GoalMixture(current=0.0, future=1.0, random=0.0, geometric=False)
VALUE_GOALS = GoalMixture(current=0.2, future=0.5, random=0.3, geometric=True)

HIERARCHY_ACTOR_GOALS = replace(ACTOR_GOALS, geometric=True)
HIERARCHY_VALUE_GOALS = replace(VALUE_GOALS, geometric=False)

QRL_VALUE_GOALS = GoalMixture(current=0.0, future=0.0, random=1.0, geometric=False)
CRL_VALUE_GOALS = GoalMixture(current=0.0, future=1.0, random=0.0, geometric=True)
