"""The input of a training step: transitions with relabelled goals, and how they are drawn."""

from dataclasses import dataclass
from typing import TypeVar

from flax import struct
from jaxtyping import Float, Int

from pigbench.agents.goals import GoalMixture
from pigbench.shapes import Array

T = TypeVar("T")


@dataclass(frozen=True)
class SubgoalSampling:
    """How a hierarchy wants its `Subgoals` drawn: K = `steps`, and the low level's value goals."""

    steps: int
    low_value_goals: GoalMixture | None  # None: the low level has no value of its own
    low_discount: float


@dataclass(frozen=True)
class Sampling:
    """How an agent wants its batches drawn; `discount` is that of geometric future goals.

    Raises ValueError if there are to be subgoals without value goals.
    """

    value_goals: GoalMixture | None  # None: the agent learns no values
    actor_goals: GoalMixture
    discount: float
    subgoals: SubgoalSampling | None = None  # of hierarchical agents

    def __post_init__(self) -> None:
        if self.subgoals and not self.value_goals:
            raise ValueError("a hierarchy's batches need value goals: subgoals lead to them too")


@struct.dataclass
class ValueGoals:
    """A goal for the value of each transition."""

    states: Float[Array, "batch observation"]
    success: Float[Array, "batch"]  # 1 where it is the transition's own first state, else 0


@struct.dataclass
class Subgoals:
    """What a hierarchy also needs, for the same transitions.

    A subgoal is the state K steps after the transition's first state, or the goal or the episode's
    last state if that comes sooner.
    """

    value_subgoals: Float[Array, "batch observation"]  # towards the value goals
    value_steps: Int[Array, "batch"]  # steps to the value subgoals
    value_success: Float[Array, "batch"]  # 1 where the subgoal is itself the value goal, else 0
    actor_subgoals: Float[Array, "batch observation"]  # towards the actor goals
    low_actor_goals: Float[Array, "batch observation"]  # K steps ahead or the episode's last
    low_for_value: ValueGoals | None = None  # `Batch.for_value` of the low level


@struct.dataclass
class Batch:
    """Transitions, each with a goal for the actor, and with what else a `Sampling` asks for."""

    observations: Float[Array, "batch observation"]
    actions: Float[Array, "batch action"]
    next_observations: Float[Array, "batch observation"]
    actor_goals: Float[Array, "batch observation"]
    for_value: ValueGoals | None = None
    subgoals: Subgoals | None = None

    @property
    def value_goals(self) -> Float[Array, "batch observation"]:
        """The goals for the value. Raises ValueError if the batch was drawn without."""
        return _drawn("value goals", self.for_value).states

    @property
    def value_success(self) -> Float[Array, "batch"]:
        """1 where the first state is itself the value goal, else 0. Raises as `value_goals`."""
        return _drawn("value goals", self.for_value).success

    @property
    def required_subgoals(self) -> Subgoals:
        """The subgoals. Raises ValueError if the batch was drawn without."""
        return _drawn("subgoals", self.subgoals)


def _drawn(what: str, part: T | None) -> T:
    if part is None:
        raise ValueError(f"the batch has no {what}: the agent's `sampling` must ask for them")
    return part
