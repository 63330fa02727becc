"""What a training step sees: transitions with relabelled goals, and how they are drawn."""

import math
from dataclasses import dataclass

import jax
from flax import struct

from pigbench.errors import UserError


@dataclass(frozen=True)
class GoalMixture:
    """Where the goal of a transition comes from: three probabilities that sum to 1.

    `current` is the transition's own first state, `future` a later state of its episode, `random`
    any state of the data set. With `geometric`, the steps to a future goal are geometric with the
    discount, clipped at the episode's end; otherwise uniform over the rest of the episode.

    Raises `UserError` if a probability lies outside [0, 1] or the sum is not 1.
    """

    current: float  # share of goals that are the transition's own first state
    future: float  # share of goals that are a later state of the same episode
    random: float  # share of goals that are any state of the data set
    geometric: bool  # draw the steps to a later state geometrically, by the discount, not uniformly

    def __post_init__(self) -> None:
        shares = (self.current, self.future, self.random)
        if not (all(0 <= share <= 1 for share in shares) and math.isclose(sum(shares), 1)):
            raise UserError(
                f"goal mixture (current, future, random) is {shares}: "
                "it must be three probabilities that sum to 1"
            )


@dataclass(frozen=True)
class SubgoalSampling:
    """How a hierarchy wants its `Subgoals`: K = `steps`, and how the low level's goals lie."""

    steps: int
    low_value_goals: GoalMixture
    low_discount: float


@dataclass(frozen=True)
class Sampling:
    """How an agent wants its batches drawn; `discount` sets the reach of geometric future goals."""

    value_goals: GoalMixture
    actor_goals: GoalMixture
    discount: float
    subgoals: SubgoalSampling | None = None  # of hierarchical agents


@struct.dataclass
class Subgoals:
    """What a hierarchy needs besides, for the same B transitions.

    A subgoal is the state K steps after a transition's first, or the episode's last state or the
    goal where that comes sooner.
    """

    value_subgoals: jax.Array  # (B, observation_size), on the way to the value goals
    value_steps: jax.Array  # (B,) int32: steps to the value subgoals
    value_success: jax.Array  # (B,) float32: 1 where the subgoal is itself the value goal, else 0
    actor_subgoals: jax.Array  # (B, observation_size), on the way to the actor goals
    low_value_goals: jax.Array  # (B, observation_size)
    low_value_success: jax.Array  # (B,) float32: as `Batch.value_success`, of the low level's goals
    low_actor_goals: jax.Array  # (B, observation_size), K steps on or the episode's last


@struct.dataclass
class Batch:
    """B transitions, with a goal each for the value and for the actor."""

    observations: jax.Array  # (B, observation_size)
    actions: jax.Array  # (B, action_size)
    next_observations: jax.Array  # (B, observation_size)
    value_goals: jax.Array  # (B, observation_size)
    value_success: (
        jax.Array
    )  # (B,) float32: 1 where the first state is itself the value goal, else 0
    actor_goals: jax.Array  # (B, observation_size)
    subgoals: Subgoals | None = None  # where the agent's `Sampling` asks for them
