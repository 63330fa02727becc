"""`pigbench evaluate`: roll out a trained policy on every task."""

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from pigbench import envs
from pigbench.errors import UserError
from pigbench.evaluation import episodes
from pigbench.evaluation.settings import Evaluation
from pigbench.runs.run import read_run
from pigbench.seeds import Seed
from pigbench.support.lock import only_writer
from pigbench.support.progress import Progress

if TYPE_CHECKING:
    from pigbench.runs.restore import Trained

_MOST_NOISE = 1000.0  # mm, more than the table is long


@dataclasses.dataclass(frozen=True)
class Evaluate:
    """Evaluate a run's policy on all tasks of its environment.

    The episodes replace those of the same training step in the run's episodes.csv; fewer episodes
    replace more only with --replace. With --noise, they go to separate files, for
    `pigbench table --show noise`.
    """

    run_folder: tyro.conf.Positional[Path]
    """Folder of the run."""
    checkpoint: str = "last"
    """Policy: last, best (in the evaluations so far), or that of a training step."""
    episodes: int = Evaluation.episodes
    """Episodes per task."""
    seed: Seed = Evaluation.seed
    """Seed of the scenes and of the policy's random draws."""
    engine: str | None = None
    """Physics engine, by default that of the run's own evaluations. Each episode's is recorded."""
    replace: bool = False
    """Allow fewer episodes to replace more."""
    noise: tuple[float, ...] = ()
    """Evaluate with each of these standard deviations, in millimetres, of every coordinate of the
    cubes' estimated positions, instead of the environment's own."""

    def __post_init__(self) -> None:
        for level in self.noise:
            if not 0 <= level <= _MOST_NOISE:
                raise UserError(f"noise is {level:g}: it must be from 0 to {_MOST_NOISE:g} mm")

    def run(self) -> None:
        """Evaluate, record and print the success of each task."""
        from pigbench.runs.restore import noisy, restore

        run = read_run(self.run_folder)
        with only_writer(self.run_folder):
            trained = restore(self.run_folder, engine=self.engine, checkpoint=self.checkpoint)
            if not self.noise:
                self._evaluate(trained, trained.env, run.episodes_path)
            for level in self.noise:
                print(f"noise of {level:g} mm")
                self._evaluate(trained, noisy(trained, level / 1000), run.noise_path(level))

    def _evaluate(self, trained: "Trained", env: "envs.CubeEnv", path: Path) -> None:
        from pigbench.evaluation.rollouts import as_episodes, make_evaluator

        evaluation, step = Evaluation(self.episodes, self.seed), int(trained.state.step)
        self._check_replaced(path, trained, count=self.episodes * env.num_tasks)
        evaluate = make_evaluator(env, trained.agent, evaluation)
        with Progress("evaluate", total=env.episode_length, unit="control steps") as progress:
            outcome = evaluate(trained.state.acting, progress.reach)
        episodes.record(path, as_episodes(outcome, env, evaluation, step=step))
        for task, successes in zip(env.spec.tasks, outcome["success"], strict=True):
            print(f"{task.name:28} {successes.sum():3d} of {self.episodes}")
        print(f"{'all tasks':28} {100 * outcome['success'].mean():.1f} %")

    def _check_replaced(self, path: Path, trained: "Trained", *, count: int) -> None:
        """Print how many episodes `count` new ones replace.

        Raises UserError if they are more than `count`, unless `replace` is set.
        """
        step = int(trained.state.step)
        old = [episode for episode in episodes.read_any(path) if episode.step == step]
        if not old:
            return
        what = (
            f"the {len(old)} episodes of step {step:,} (seed {old[0].seed}, {old[0].engine}) "
            f"by {count} (seed {self.seed}, {trained.env.backend})"
        )
        if count < len(old) and not self.replace:
            raise UserError(f"this would replace {what}: add --replace to allow it")
        print(f"replacing {what}")
