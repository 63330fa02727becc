"""Training a method: updates in a compiled loop, with evaluations and checkpoints on the way.

Seed and step determine every batch and every draw, and evaluation has keys of its own, so a run
that was killed and restarted ends with bitwise the same parameters as one that was not.
"""

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

import jax
import jax.numpy as jnp

from pigbench import agents, envs, seeds
from pigbench.agents import Agent, Batch, Metrics, TrainState
from pigbench.data.sampler import Rows
from pigbench.errors import require
from pigbench.support.progress import Progress
from pigbench.trackers import Tracker
from pigbench.training import batches, episodes
from pigbench.training.batches import Batches
from pigbench.training.checkpoints import Checkpoints, Kept, last_two
from pigbench.training.evaluate import Evaluation, make_evaluator
from pigbench.training.examination import Examination
from pigbench.training.films import keep_films, make_filmer
from pigbench.training.ledger import Ledger
from pigbench.training.metrics import MetricsLog
from pigbench.training.run import Keep, Run, common_step
from pigbench.training.sharding import SEEDS, Sharding

Tree = TypeVar("Tree")

ONE_DEVICE = Sharding()

Updates = Callable[[Sequence[TrainState], int, int], tuple[list[TrainState], list[Metrics]]]
"""Updates states from one step up to another; returns the new states and mean metrics."""


_KEPT: Mapping[Keep, Callable[[Run], Kept]] = {
    "last": lambda run: last_two,
    "best": lambda run: lambda steps: {*last_two(steps), _best_step(run)},
    "all": lambda run: lambda steps: steps,
}


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
        """Whether there is an evaluation after that step."""
        return step % self.evaluate_every == 0 or step == self.steps


def train(
    runs: Sequence[Run],
    agent: Agent,
    rows: Rows,
    env: "envs.CubeEnv",
    *,
    schedule: Schedule,
    evaluation: Evaluation,
    sharding: Sharding = ONE_DEVICE,
    keep: Keep = "last",
    shown_by: Sequence[type[Tracker]] = (),
    films: bool = False,
    remark: str = "",
) -> list[TrainState]:
    """Train to the schedule's end, from the last checkpoint that all `runs` have, if there is one.

    Evaluations, films and checkpoints at the end of a shorter schedule are dropped unless this one
    has them too: the files are those of a run that had this schedule from the start. Raises
    UserError as `common_step` does.
    """
    keys = [jax.random.split(seeds.key(run.config.seed)) for run in runs]
    evaluator = make_evaluator(env, agent, evaluation)
    with contextlib.ExitStack() as stack:
        key = join([step_key for _, step_key in keys])
        source = stack.enter_context(batches.of(rows, agent, key))
        updates = make_updates(agent, key, source, sharding)
        checkpoints = [
            stack.enter_context(Checkpoints(run.checkpoints_path, kept=_KEPT[keep](run)))
            for run in runs
        ]
        for run, saved in zip(runs, checkpoints, strict=True):
            _keep_scheduled(run, saved, schedule)
        states = [agents.create(agent, init_key) for init_key, _ in keys]
        saved_step = common_step(runs)
        if saved_step is not None:
            states = [
                one.restore(fresh, saved_step)
                for one, fresh in zip(checkpoints, states, strict=True)
            ]
        step = saved_step or 0
        logs = [stack.enter_context(MetricsLog(run.path, step=step)) for run in runs]
        trackers = [
            [stack.enter_context(tracker(run, step=step)) for tracker in shown_by] for run in runs
        ]
        ledgers = [Ledger(*one) for one in zip(runs, checkpoints, logs, trackers, strict=True)]
        filmer = make_filmer(env, agent, evaluation) if films else None
        progress = stack.enter_context(
            Progress(runs[0].config.method, total=schedule.steps, unit="updates", done=step)
        )
        examine = Examination(env, evaluation, evaluator, filmer, progress)
        ending = remark and f", {remark}"
        note = "resumed" if saved_step is not None else examine(states, ledgers, step=step)
        progress.advance(0, f"{note}{ending}")
        while step < schedule.steps:
            stop = schedule.next_stop(step)
            states, metrics = updates(states, step, stop)
            for ledger, one in zip(ledgers, metrics, strict=True):
                ledger.enter_metrics(stop, one)
            progress.advance(stop - step, f"{note}{ending}")
            step = stop
            if schedule.evaluates(step):
                note = examine(states, ledgers, step=step)
                progress.advance(0, f"{note}{ending}")
    return states


def _keep_scheduled(run: Run, checkpoints: Checkpoints, schedule: Schedule) -> None:
    """Drop the checkpoints, episodes and films of steps at which the schedule has no evaluation."""
    checkpoints.drop(lambda step: not schedule.evaluates(step))
    for path in (run.episodes_path, *run.noise_paths().values()):
        episodes.keep(path, schedule.evaluates)
    keep_films(run.films_path, schedule.evaluates)


def _best_step(run: Run) -> int:
    return episodes.best_step(episodes.read(run.episodes_path))


def make_updates(
    agent: Agent, key: jax.Array, source: Batches, sharding: Sharding = ONE_DEVICE
) -> Updates:
    """The updates of the seed with `key`, or of several seeds together with keys (S,).

    Update t of a seed draws its batch and everything else from `fold_in(key, t)` alone.
    """

    def loop(
        state: TrainState, key: jax.Array, part: Any, start: int, stop: int
    ) -> tuple[TrainState, Metrics]:
        """Do the updates of a part; also returns the sums of their metrics."""

        def batch(step: jax.Array | int) -> Batch:
            batch_key, _ = batches.keys_of(key, step)
            return sharding.share_batch(source.batch(part, batch_key, step))

        def update(
            step: jax.Array | int, state: TrainState, batch: Batch
        ) -> tuple[TrainState, Metrics]:
            _, update_key = batches.keys_of(key, step)
            return agents.update(agent, state, batch, update_key)

        def body(step: jax.Array, carry: tuple[TrainState, Batch, Metrics]):
            state, now, sums = carry
            state, metrics = update(step, state, now)
            return state, batch(step + 1), jax.tree.map(jnp.add, sums, metrics)

        # Each iteration is passed its batch, so that an update is compiled independently of the
        # batch's source and gives the same numbers for every source.
        first = batch(start)
        _, metrics = jax.eval_shape(update, start, state, first)
        sums = jax.tree.map(lambda x: jnp.zeros(x.shape, x.dtype), metrics)
        state, _, sums = jax.lax.fori_loop(start, stop, body, (state, first, sums))
        return state, sums

    # Joined within the program: outside, every leaf of every state would be a separate call.
    @partial(jax.jit, donate_argnums=0)
    def run(
        states: Sequence[TrainState], key: jax.Array, part: Any, start: int, stop: int
    ) -> tuple[list[TrainState], list[Metrics]]:
        if key.ndim:
            together = jax.vmap(loop, in_axes=(0, 0, source.axis, None, None), spmd_axis_name=SEEDS)
            state, sums = together(sharding.share_seeds(join(states)), key, part, start, stop)
        else:
            state, sums = loop(join(states), key, part, start, stop)
        return _part(state, len(states)), _part(sums, len(states))

    def updates(
        states: Sequence[TrainState], start: int, stop: int
    ) -> tuple[list[TrainState], list[Metrics]]:
        sums, done, states = [], start, sharding.spread(states)
        for part, end in source.parts(start, stop):
            states, part_sums = run(states, key, part, done, end)
            jax.block_until_ready(sums[-1:])  # so that at most two parts are on the device
            sums.append(part_sums)
            done = end
        means = [
            jax.tree.map(lambda *x: sum(x) / (stop - start), *own)
            for own in zip(*jax.device_get(sums), strict=True)
        ]
        return list(sharding.collect(states)), means

    return updates


def join(trees: Sequence[Tree]) -> Tree:
    """Stack the trees of several seeds; the tree of a single seed is returned as it is."""
    return jax.tree.map(lambda *x: jnp.stack(x), *trees) if len(trees) > 1 else trees[0]


def _part(tree: Tree, count: int) -> list[Tree]:
    """The inverse of `join`."""
    if count == 1:
        return [tree]
    return [jax.tree.map(lambda leaf: leaf[number], tree) for number in range(count)]  # noqa: B023
