"""`pigbench evaluate`: roll out a trained policy on every task."""

import dataclasses
from pathlib import Path

import jax
import tyro

from pigbench import agents, envs
from pigbench.errors import UserError
from pigbench.training import episodes
from pigbench.training.checkpoints import Checkpoints
from pigbench.training.evaluate import Evaluation, as_episodes, make_evaluator
from pigbench.training.run import agent_config, read_run


@dataclasses.dataclass(frozen=True)
class Evaluate:
    """Evaluate a run's last checkpoint on all tasks of its environment.

    The episodes replace those of the same training step in the run's episodes.csv.
    """

    run_folder: tyro.conf.Positional[Path]
    """Folder of the run."""
    episodes: int = Evaluation.episodes
    """Episodes of each task."""
    seed: int = Evaluation.seed
    """Seed of scenes and of the policy's draws."""
    engine: str = envs.DEFAULT_ENGINE
    """Physics engine."""

    def run(self) -> None:
        """Evaluate, record and print the success of each task."""
        evaluation = Evaluation(self.episodes, self.seed)
        run = read_run(self.run_folder)
        env = envs.make(run.config.environment, engine=self.engine, profile=run.config.physics)
        agent = agents.build(
            run.config.method,
            agent_config(run),
            observation_size=env.observation_size,
            action_size=env.action_size,
            layout=env.layout,
        )
        with Checkpoints(run.checkpoints_path) as checkpoints:
            state = checkpoints.restore(agents.create(agent, jax.random.key(0)))
        if state is None:
            raise UserError(f"{self.run_folder} has no checkpoint yet; train it first")
        outcome = make_evaluator(env, agent, evaluation)(state.params)
        rows = as_episodes(outcome, env, evaluation, step=int(state.step))
        episodes.record(run.episodes_path, rows)
        for task, successes in zip(env.spec.tasks, outcome.success, strict=True):
            print(f"{task.name:28} {successes.sum():3d} of {self.episodes}")
        print(f"{'all tasks':28} {100 * outcome.success.mean():.1f} %")
