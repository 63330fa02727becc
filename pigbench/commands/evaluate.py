"""`pigbench evaluate`: roll out a trained policy on every task."""

import dataclasses
from pathlib import Path

import tyro

from pigbench import envs
from pigbench.errors import UserError
from pigbench.seeds import Seed
from pigbench.support.lock import only_writer
from pigbench.support.progress import Progress
from pigbench.training import episodes
from pigbench.training.evaluate import Evaluation, as_episodes, make_evaluator
from pigbench.training.restore import restore
from pigbench.training.run import Run, read_run


@dataclasses.dataclass(frozen=True)
class Evaluate:
    """Evaluate a run's policy on all tasks of its environment.

    The episodes replace those of the same training step in the run's episodes.csv: fewer than those
    only with --replace.
    """

    run_folder: tyro.conf.Positional[Path]
    """Folder of the run."""
    checkpoint: str = "last"
    """Which policy: last, best (of the evaluations so far), or that of a training step."""
    episodes: int = Evaluation.episodes
    """Episodes of each task."""
    seed: Seed = Evaluation.seed
    """Seed of scenes and of the policy's draws."""
    engine: str = dataclasses.field(default_factory=envs.default_engine)
    """Physics engine."""
    replace: bool = False
    """Replace more episodes by fewer."""

    def run(self) -> None:
        """Evaluate, record and print the success of each task."""
        evaluation = Evaluation(self.episodes, self.seed)
        run = read_run(self.run_folder)
        with only_writer(self.run_folder):
            _, env, agent, state = restore(
                self.run_folder, engine=self.engine, checkpoint=self.checkpoint
            )
            self._check_replaced(run, step=int(state.step), count=self.episodes * env.num_tasks)
            evaluate = make_evaluator(env, agent, evaluation)
            with Progress("evaluate", total=env.episode_length, unit="control steps") as progress:
                outcome = evaluate(state.params, progress.reach)
            rows = as_episodes(outcome, env, evaluation, step=int(state.step))
            episodes.record(run.episodes_path, rows)
        for task, successes in zip(env.spec.tasks, outcome["success"], strict=True):
            print(f"{task.name:28} {successes.sum():3d} of {self.episodes}")
        print(f"{'all tasks':28} {100 * outcome['success'].mean():.1f} %")

    def _check_replaced(self, run: Run, *, step: int, count: int) -> None:
        """Say how many episodes `count` others replace; UserError if they are more, unasked."""
        recorded = episodes.read(run.episodes_path) if run.episodes_path.exists() else []
        seeds = [episode.seed for episode in recorded if episode.step == step]
        if not seeds:
            return
        what = (
            f"the {len(seeds)} episodes of step {step:,} (seed {seeds[0]}) by {count} "
            f"(seed {self.seed})"
        )
        if count < len(seeds) and not self.replace:
            raise UserError(f"this would replace {what}: ask for it with --replace")
        print(f"replacing {what}")
