"""Training a method: updates, with evaluations and checkpoints on the way.

Seed and step determine every batch and every draw, and evaluation has keys of its own, so a run
that was killed and restarted ends with bitwise the same parameters as one that was not.
"""

import contextlib
from collections.abc import Callable, Mapping, Sequence
from functools import partial

import jax
from jaxtyping import Array, Key

from pigbench import agents, envs, seeds
from pigbench.agents import Agent, TrainState
from pigbench.data.sampler import Rows
from pigbench.evaluation import episodes
from pigbench.evaluation.films import keep_films
from pigbench.evaluation.settings import Evaluation
from pigbench.runs.checkpoints import Checkpoints, Kept, last_two
from pigbench.runs.run import Keep, Run
from pigbench.support.progress import Progress
from pigbench.trackers import Tracker
from pigbench.training import batches
from pigbench.training.ledger import Ledger
from pigbench.training.run_evaluator import RunEvaluator
from pigbench.training.schedule import Schedule
from pigbench.training.sharding import Sharding
from pigbench.training.together import common_step
from pigbench.training.updates import ONE_DEVICE, join, make_updates, split

_KEPT: Mapping[Keep, Callable[[Run], Kept]] = {
    "last": lambda run: last_two,
    "best": lambda run: lambda steps: {*last_two(steps), _best_step(run)},
    "all": lambda run: lambda steps: steps,
}


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
    ending = remark and f", {remark}"
    init_keys, step_keys = zip(
        *(jax.random.split(seeds.key(one.config.seed)) for one in runs), strict=True
    )
    key = join(step_keys)
    with contextlib.ExitStack() as stack:
        source = stack.enter_context(batches.of(rows, agent, key))
        checkpoints = [stack.enter_context(_scheduled(run, schedule, keep)) for run in runs]
        saved_step = common_step(runs)
        states = _begun(agent, init_keys, checkpoints, saved_step)
        step = saved_step or 0
        ledgers = [
            stack.enter_context(Ledger.opened(run, saved, shown_by, step=step))
            for run, saved in zip(runs, checkpoints, strict=True)
        ]
        progress = stack.enter_context(
            Progress(runs[0].config.method, total=schedule.steps, unit="updates", done=step)
        )
        evaluate = RunEvaluator.of(env, agent, evaluation, progress, films=films)
        updates = make_updates(agent, key, source, sharding)

        note = "resumed" if saved_step is not None else evaluate(states, ledgers, step=step)
        progress.advance(0, note + ending)
        state = join(states)
        while step < schedule.steps:
            stop = schedule.next_stop(step)
            state, metrics = updates(state, step, stop)
            for ledger, one in zip(ledgers, metrics, strict=True):
                ledger.enter_metrics(stop, one)
            progress.advance(stop - step, note + ending)
            step = stop
            if schedule.evaluates(step):
                states = split(sharding.collect(state), len(runs))
                note = evaluate(states, ledgers, step=step)
                progress.advance(0, note + ending)
    return states


def _begun(
    agent: Agent,
    keys: Sequence[Key[Array, ""]],
    checkpoints: Sequence[Checkpoints],
    saved_step: int | None,
) -> list[TrainState]:
    """The states from which training goes on: saved ones, or new ones of these keys.

    Both are committed to a device: if only saved ones were, they would need other programs.
    """
    if saved_step is None:
        device = jax.local_devices()[0]
        return [jax.device_put(agents.create(agent, key), device) for key in keys]
    like = jax.eval_shape(partial(agents.create, agent), keys[0])
    return [saved.restore(like, saved_step) for saved in checkpoints]


def _scheduled(run: Run, schedule: Schedule, keep: Keep) -> Checkpoints:
    """The run's checkpoints; those of steps at which the schedule has no evaluation are dropped.

    So are such steps' episodes and films.
    """
    checkpoints = Checkpoints(run.checkpoints_path, kept=_KEPT[keep](run))
    checkpoints.drop(lambda step: not schedule.evaluates(step))
    for path in (run.episodes_path, *run.noise_paths().values()):
        episodes.keep(path, schedule.evaluates)
    keep_films(run.films_path, schedule.evaluates)
    return checkpoints


def _best_step(run: Run) -> int:
    return episodes.best_step(episodes.read(run.episodes_path))
