"""Training a method: updates in a compiled loop, evaluated and saved as it goes.

Seed and step determine every batch and every draw, and evaluation has keys of its own, so a run
that was killed and started again ends with the same parameters, to the bit, as one that was not.
"""

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

import jax
import jax.numpy as jnp

from pigbench import agents, seeds
from pigbench.agents import Agent, Metrics, TrainState
from pigbench.data import sampler
from pigbench.data.sampler import Rows
from pigbench.envs import CubeEnv
from pigbench.errors import UserError
from pigbench.support.progress import Progress
from pigbench.training import episodes
from pigbench.training.checkpoints import Checkpoints, common_step
from pigbench.training.evaluate import Evaluation, Outcome, as_episodes, make_evaluator
from pigbench.training.metrics import MetricsLog
from pigbench.training.milestones import BRIEF
from pigbench.training.run import Run

Tree = TypeVar("Tree")


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
    runs: Sequence[Run],
    agent: Agent,
    rows: Rows,
    env: CubeEnv,
    *,
    schedule: Schedule,
    evaluation: Evaluation,
) -> list[TrainState]:
    """Train to the schedule's end, from the last checkpoint that all `runs` have, if there is one.

    The runs differ in their seeds alone, and are trained together, in one program.
    """
    keys = [jax.random.split(seeds.key(run.config.seed)) for run in runs]
    evaluator = make_evaluator(env, agent, evaluation)
    updates = make_updates(agent, [step_key for _, step_key in keys])
    with contextlib.ExitStack() as stack:
        checkpoints = [stack.enter_context(Checkpoints(run.checkpoints_path)) for run in runs]
        states = [agents.create(agent, init_key) for init_key, _ in keys]
        saved_step = common_step(checkpoints)
        if saved_step is not None:
            states = [
                one.restore(fresh, saved_step)
                for one, fresh in zip(checkpoints, states, strict=True)
            ]
        step = saved_step or 0
        logs = [stack.enter_context(MetricsLog(run.path, step=step)) for run in runs]
        progress = stack.enter_context(
            Progress(runs[0].config.method, total=schedule.steps, unit="updates", done=step)
        )

        def evaluate_and_save() -> str:
            outcomes = []
            for run, state, saved in zip(runs, states, checkpoints, strict=True):
                outcome = evaluator(
                    state.params,
                    lambda time: progress.advance(0, f"evaluating, {time} of {env.episode_length}"),
                )
                episodes.record(run.episodes_path, as_episodes(outcome, env, evaluation, step=step))
                saved.save(state)
                outcomes.append(outcome)
            return _brief(outcomes)

        note = evaluate_and_save() if saved_step is None else "resumed"
        progress.advance(0, note)
        while step < schedule.steps:
            stop = schedule.next_stop(step)
            states, metrics = updates(states, rows, stop - step)
            for log, one in zip(logs, metrics, strict=True):
                log.write(stop, one)
            progress.advance(stop - step, note)
            step = stop
            if step % schedule.evaluate_every == 0 or step == schedule.steps:
                note = evaluate_and_save()
    return states


def _brief(outcomes: Sequence[Outcome]) -> str:
    """What share of episodes came how far, one outcome a seed: "held 60/55 %, lifted 40/38 %"."""

    def shares(name: str) -> str:
        return "/".join(f"{100 * outcome[name].mean():.0f}" for outcome in outcomes)

    return ", ".join(f"{name} {shares(name)} %" for name in BRIEF)


def make_updates(
    agent: Agent, keys: Sequence[jax.Array]
) -> Callable[[Sequence[TrainState], Rows, int], tuple[list[TrainState], list[Metrics]]]:
    """A function that does a number of updates of each state, and returns their metrics' means.

    There is a state a key. Update t of a state draws its batch from `fold_in(key, t)` alone.
    """

    def update(state: TrainState, key: jax.Array, rows: Rows) -> tuple[TrainState, Metrics]:
        batch_key, update_key = jax.random.split(jax.random.fold_in(key, state.step))
        batch = sampler.sample(batch_key, rows, agent.sampling, agent.config.batch_size)
        return agents.update(agent, state, batch, update_key)

    def loop(
        state: TrainState, key: jax.Array, rows: Rows, count: int
    ) -> tuple[TrainState, Metrics]:
        _, metrics = jax.eval_shape(update, state, key, rows)
        sums = jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), metrics)

        def body(_: int, carry: tuple[TrainState, Metrics]) -> tuple[TrainState, Metrics]:
            state, sums = carry
            state, metrics = update(state, key, rows)
            return state, jax.tree.map(jnp.add, sums, metrics)

        state, sums = jax.lax.fori_loop(0, count, body, (state, sums))
        return state, jax.tree.map(lambda x: x / count, sums)

    alone = jax.jit(loop, donate_argnums=0)

    # Stacked within the program: outside, every leaf of every state would be a call of its own.
    @partial(jax.jit, donate_argnums=0)
    def together(
        states: Sequence[TrainState], rows: Rows, count: int
    ) -> tuple[list[TrainState], Metrics]:
        vectorized = jax.vmap(loop, in_axes=(0, 0, None, None))
        state, metrics = vectorized(_stack(states), jnp.stack(keys), rows, count)
        return _unstack(state, len(keys)), metrics

    def updates(
        states: Sequence[TrainState], rows: Rows, count: int
    ) -> tuple[list[TrainState], list[Metrics]]:
        if len(keys) == 1:
            state, metrics = alone(states[0], keys[0], rows, count)
            return [state], [jax.device_get(metrics)]
        trained, metrics = together(states, rows, count)
        return trained, _unstack(jax.device_get(metrics), len(keys))

    return updates


def _stack(trees: Sequence[Tree]) -> Tree:
    return jax.tree.map(lambda *leaves: jnp.stack(leaves), *trees)


def _unstack(tree: Tree, count: int) -> list[Tree]:
    return [jax.tree.map(lambda leaf: leaf[number], tree) for number in range(count)]  # noqa: B023
