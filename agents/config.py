"""The fields common to all agents' configurations."""

from dataclasses import dataclass

from pigbench.agents.batch import GoalMixture
from pigbench.agents.representations import GOALS
from pigbench.errors import lookup, require

VALUE_GOALS = GoalMixture(current=0.2, future=0.5, random=0.3, geometric=True)
ACTOR_GOALS = GoalMixture(current=0.0, future=1.0, random=0.0, geometric=False)


@dataclass(frozen=True)
class AgentConfig:
    """Hyperparameters that all methods share; the defaults are the paper's where it names them.

    Raises `UserError` if a value is out of range.
    """

    learning_rate: float = 3e-4  # of Adam
    batch_size: int = 1024  # transitions per update
    actor_hidden_sizes: tuple[int, ...] = (1024, 1024, 1024, 1024)  # layers of policies
    value_hidden_sizes: tuple[int, ...] = (1024, 1024, 1024, 1024)  # layers of values and critics
    layer_norm: bool = True  # layer normalisation in values and vector fields
    actor_layer_norm: bool = False  # layer normalisation in Gaussian policies
    discount: float = 0.999
    target_rate: float = 0.005  # tau: the weight of the online parameters in each target update
    goals: str = "state"  # what networks see of a goal: state or cubes
    value_goals: GoalMixture = VALUE_GOALS  # where goals for values come from
    actor_goals: GoalMixture = ACTOR_GOALS  # where goals for policies come from

    def __post_init__(self) -> None:
        lookup("goals", GOALS, self.goals)
        require(self, lambda x: x > 0, "positive", "learning_rate", "batch_size")
        require(self, lambda x: 0 < x < 1, "between 0 and 1, both excluded", "discount")
        require(self, lambda x: 0 < x <= 1, "above 0 and at most 1", "target_rate")
        require(
            self,
            lambda sizes: all(size > 0 for size in sizes),
            "positive numbers",
            "actor_hidden_sizes",
            "value_hidden_sizes",
        )
