"""The settings of an evaluation, without JAX."""

from dataclasses import dataclass

from pigbench import seeds
from pigbench.errors import require
from pigbench.seeds import Seed
from pigbench.support import memory


@dataclass(frozen=True)
class Evaluation:
    """How a policy is evaluated."""

    episodes: int = 10
    """Episodes per task."""
    seed: Seed = 0
    """Seed of the scenes and of the policy's random draws."""

    def __post_init__(self) -> None:
        require(self, lambda x: x >= 1, "at least 1", "episodes")
        seeds.check(self.seed)
        memory.require_for(self.episodes)  # for one task; `rollouts.begin` checks for all
