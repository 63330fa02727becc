"""What happens to policies at an evaluation: they act, are filmed, and it is all written down."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from pigbench import envs
from pigbench.agents import TrainState
from pigbench.support.progress import Progress
from pigbench.training.evaluate import Evaluation, Evaluator, Outcome, as_episodes
from pigbench.training.films import Filmer
from pigbench.training.ledger import Ledger
from pigbench.training.measures import BRIEF


@dataclass(frozen=True)
class Examination:
    """Evaluates states, films them if it can, and enters what comes of it."""

    env: "envs.CubeEnv"
    evaluation: Evaluation
    evaluate: Evaluator
    film: Filmer | None
    progress: Progress

    def __call__(
        self, states: Sequence[TrainState], ledgers: Sequence[Ledger], *, step: int
    ) -> str:
        """Examine the states after `step` updates; returns how far their episodes got."""
        return _brief(
            [self._one(state, ledger, step) for state, ledger in zip(states, ledgers, strict=True)]
        )

    def _one(self, state: TrainState, ledger: Ledger, step: int) -> Outcome:
        outcome = self.evaluate(state.acting, partial(self._tell, "evaluating"))
        rows = as_episodes(outcome, self.env, self.evaluation, step=step)
        films = {}
        if self.film is not None:
            folder = ledger.run.films_path / f"{step:09d}"
            films = self.film(state.acting, folder, partial(self._tell, "filming"))
        ledger.enter_evaluation(state, rows, films, step=step)
        return outcome

    def _tell(self, doing: str, time: int) -> None:
        self.progress.advance(0, f"{doing}, {time} of {self.env.episode_length}")


def _brief(outcomes: Sequence[Outcome]) -> str:
    """How far episodes got, one number per seed: "held 60/55 %, lifted 40/38 %"."""

    def shares(name: str) -> str:
        return "/".join(f"{100 * outcome[name].mean():.0f}" for outcome in outcomes)

    return ", ".join(f"{name} {shares(name)} %" for name in BRIEF)
