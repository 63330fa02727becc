"""The fields that agents' configurations share, without JAX.

A method's configuration has only fields that change what the method does. It is based on
`AgentConfig`, or on those of the classes below that say what the method consists of.
"""

from dataclasses import asdict, dataclass
from typing import Any, ClassVar

from pigbench.agents.goals import ACTOR_GOALS, GOALS, VALUE_GOALS, GoalMixture
from pigbench.errors import UserError, lookup, require


@dataclass(frozen=True)
class AgentConfig:
    """Hyperparameters that all methods share; the defaults are the paper's where it names them.

    Raises `UserError` if a value is out of range.
    """

    decided: ClassVar[tuple[str, ...]] = ()
    """Nested fields that the others decide, such as low.discount; their values have no effect."""

    learning_rate: float = 3e-4  # of Adam
    batch_size: int = 1024  # transitions per update
    actor_hidden_sizes: tuple[int, ...] = (1024, 1024, 1024, 1024)  # layers of policies
    discount: float = 0.999  # of values, and of goals that are drawn geometrically
    goals: str = "state"  # what networks see of a goal: state or cubes
    actor_goals: GoalMixture = ACTOR_GOALS  # where goals for policies come from

    def __post_init__(self) -> None:
        lookup("goals", GOALS, self.goals)
        require(self, lambda x: x > 0, "positive", "learning_rate", "batch_size")
        require(self, lambda x: 0 < x < 1, "between 0 and 1, both excluded", "discount")
        require(self, _are_positive, "positive numbers", "actor_hidden_sizes")

    def record(self) -> dict[str, Any]:
        """All fields that have an effect, by name; nested configurations are mappings too."""
        fields = asdict(self)
        for place in self.decided:
            outer, name = place.split(".")
            fields[outer].pop(name, None)
        return fields


@dataclass(frozen=True)
class PolicyConfig(AgentConfig):
    """Those of methods with Gaussian policies."""

    actor_layer_norm: bool = False  # layer normalisation in Gaussian policies


@dataclass(frozen=True)
class ValueConfig(AgentConfig):
    """Those of methods that learn values; their batches have goals for them."""

    value_hidden_sizes: tuple[int, ...] = (1024, 1024, 1024, 1024)  # layers of values and critics
    layer_norm: bool = True  # layer normalisation in values and vector fields
    value_goals: GoalMixture = VALUE_GOALS  # where goals for values come from

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, _are_positive, "positive numbers", "value_hidden_sizes")


@dataclass(frozen=True)
class TargetConfig(ValueConfig):
    """Those of methods whose values have target copies."""

    target_rate: float = 0.005  # tau: the weight of the online parameters in each target update

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self, lambda x: 0 < x <= 1, "above 0 and at most 1", "target_rate")


def no_effect(place: str) -> UserError:
    """The error for a field of `AgentConfig.decided` that is given nevertheless."""
    return UserError(f"{place} has no effect: leave it out, other hyperparameters decide it")


def _are_positive(sizes: tuple[int, ...]) -> bool:
    return all(size > 0 for size in sizes)
