"""Evaluation of runs as they train: policies act, are filmed, and it is all written down."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from pigbench import envs
from pigbench.agents import Agent, Params, TrainState
from pigbench.evaluation.films import film
from pigbench.evaluation.measures import BRIEF
from pigbench.evaluation.recording import Recording, make_recorder
from pigbench.evaluation.rollouts import Outcome, Report, as_episodes, make_evaluator
from pigbench.evaluation.settings import Evaluation
from pigbench.support.progress import Progress
from pigbench.training.ledger import Ledger


@dataclass(frozen=True)
class RunEvaluator:
    """Evaluates states, films them if `evaluate` records episodes, and enters what comes of it."""

    env: "envs.CubeEnv"
    evaluation: Evaluation
    evaluate: Callable[[Params, Report], tuple[Outcome, Sequence[Recording]]]
    progress: Progress

    @classmethod
    def of(
        cls,
        env: "envs.CubeEnv",
        agent: Agent,
        evaluation: Evaluation,
        progress: Progress,
        *,
        films: bool,
    ) -> "RunEvaluator":
        """The evaluator of the agent's states, with or without films."""
        if films:
            return cls(env, evaluation, make_recorder(env, agent, evaluation), progress)
        evaluate = make_evaluator(env, agent, evaluation)
        return cls(env, evaluation, lambda *given: (evaluate(*given), ()), progress)

    def __call__(
        self, states: Sequence[TrainState], ledgers: Sequence[Ledger], *, step: int
    ) -> str:
        """Evaluate the states after `step` updates; returns how far their episodes got."""
        return _brief(
            [self._one(state, ledger, step) for state, ledger in zip(states, ledgers, strict=True)]
        )

    def _one(self, state: TrainState, ledger: Ledger, step: int) -> Outcome:
        outcome, recordings = self.evaluate(state.acting, self._tell)
        rows = as_episodes(outcome, self.env, self.evaluation, step=step)
        folder = ledger.run.films_path / f"{step:09d}"
        films = film(self.env, recordings, folder) if recordings else {}
        ledger.enter_evaluation(state, rows, films, step=step)
        return outcome

    def _tell(self, time: int) -> None:
        self.progress.advance(0, f"evaluating, {time} of {self.env.episode_length}")


def _brief(outcomes: Sequence[Outcome]) -> str:
    """How far episodes got, one number per seed: "held 60/55 %, lifted 40/38 %"."""

    def shares(name: str) -> str:
        return "/".join(f"{100 * outcome[name].mean():.0f}" for outcome in outcomes)

    return ", ".join(f"{name} {shares(name)} %" for name in BRIEF)
