"""When training logs, evaluates, saves a checkpoint, and ends."""

from dataclasses import dataclass

from pigbench.errors import require


@dataclass(frozen=True)
class Schedule:
    """How long to train, and how often to log, and to evaluate and save, all in updates."""

    steps: int = 100_000
    log_every: int = 500
    evaluate_every: int = 5_000

    def __post_init__(self) -> None:
        require(self, lambda x: x >= 1, "at least 1", *vars(self))

    def next_stop(self, step: int) -> int:
        """The first step after `step` at which there is something to do."""
        ends = (every * (step // every + 1) for every in (self.log_every, self.evaluate_every))
        return min(*ends, self.steps)

    def evaluates(self, step: int) -> bool:
        """Whether there is an evaluation after that step, and with it a checkpoint.

        So there is at step 0, before the first update.
        """
        return step % self.evaluate_every == 0 or step == self.steps
