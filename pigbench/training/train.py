"""Training one method with one seed: updates in a compiled loop, evaluated and saved as it goes.

Seed and step determine every batch and every draw, and evaluation has keys of its own, so a run
that was killed and started again ends with the same parameters, to the bit, as one that was not.
"""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp

from pigbench import agents
from pigbench.agents import Agent, Metrics, TrainState
from pigbench.data import sampler
from pigbench.data.sampler import Rows
from pigbench.envs import CubeEnv
from pigbench.errors import UserError
from pigbench.support.progress import Progress
from pigbench.training import episodes
from pigbench.training.checkpoints import Checkpoints
from pigbench.training.evaluate import Evaluation, as_episodes, make_evaluator
from pigbench.training.metrics import MetricsLog
from pigbench.training.run import Run


@dataclass(frozen=True)
class Schedule:
    """How long to train, and after how many updates to log, and to evaluate and save."""

    steps: int = 100_000
    log_every: int = 500
    evaluate_every: int = 5_000

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if value < 1:
                raise UserError(f"{name} is {value}: it must be at least 1")

    def next_stop(self, step: int) -> int:
        """The first step after `step` at which there is something to do."""
        ends = (every * (step // every + 1) for every in (self.log_every, self.evaluate_every))
        return min(*ends, self.steps)


def train(
    run: Run,
    agent: Agent,
    rows: Rows,
    env: CubeEnv,
    *,
    schedule: Schedule,
    evaluation: Evaluation,
    seed: int,
) -> TrainState:
    """Train to the schedule's end, from the run's last checkpoint if it has one."""
    init_key, step_key = jax.random.split(jax.random.key(seed))
    evaluator = make_evaluator(env, agent, evaluation)
    updates = make_updates(agent, step_key)
    with contextlib.ExitStack() as stack:
        checkpoints = stack.enter_context(Checkpoints(run.checkpoints_path))
        fresh = agents.create(agent, init_key)
        restored = checkpoints.restore(fresh)
        state = fresh if restored is None else restored
        step = int(state.step)
        log = stack.enter_context(MetricsLog(run.path, step=step))
        progress = stack.enter_context(
            Progress(run.config.method, total=schedule.steps, unit="updates", done=step)
        )

        def evaluate_and_save(state: TrainState) -> str:
            outcome = evaluator(
                state.params,
                lambda time: progress.advance(0, f"evaluating, {time} of {env.episode_length}"),
            )
            rows = as_episodes(outcome, env, evaluation, step=int(state.step))
            episodes.record(run.episodes_path, rows)
            checkpoints.save(state)
            return f"success {100 * outcome.success.mean():.0f} %"

        note = evaluate_and_save(state) if restored is None else "resumed"
        progress.advance(0, note)
        while step < schedule.steps:
            stop = schedule.next_stop(step)
            state, metrics = updates(state, rows, stop - step)
            log.write(stop, jax.device_get(metrics))
            progress.advance(stop - step, note)
            step = stop
            if step % schedule.evaluate_every == 0 or step == schedule.steps:
                note = evaluate_and_save(state)
    return state


def make_updates(
    agent: Agent, key: jax.Array
) -> Callable[[TrainState, Rows, int], tuple[TrainState, Metrics]]:
    """A function that does a number of updates, and returns the metrics' mean over them.

    Update t draws its batch from `fold_in(key, t)` alone.
    """

    def update(state: TrainState, rows: Rows) -> tuple[TrainState, Metrics]:
        batch_key, update_key = jax.random.split(jax.random.fold_in(key, state.step))
        batch = sampler.sample(batch_key, rows, agent.sampling, agent.config.batch_size)
        return agents.update(agent, state, batch, update_key)

    @partial(jax.jit, donate_argnums=0)
    def updates(state: TrainState, rows: Rows, count: int) -> tuple[TrainState, Metrics]:
        _, metrics = jax.eval_shape(update, state, rows)
        sums = jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), metrics)

        def body(_: int, carry: tuple[TrainState, Metrics]) -> tuple[TrainState, Metrics]:
            state, sums = carry
            state, metrics = update(state, rows)
            return state, jax.tree.map(jnp.add, sums, metrics)

        state, sums = jax.lax.fori_loop(0, count, body, (state, sums))
        return state, jax.tree.map(lambda x: x / count, sums)

    return updates
