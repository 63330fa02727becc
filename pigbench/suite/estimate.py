"""An estimate of how long a suite will take, from rates measured on this machine."""

from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from pigbench import envs
from pigbench.agents import AgentConfig
from pigbench.bench import simulation, training
from pigbench.bench.timing import alternate
from pigbench.suite.checks import Trainings
from pigbench.suite.jobs import data_folder
from pigbench.suite.spec import Environment, Suite, SuiteCell
from pigbench.suite.status import DONE, Status, is_complete, status
from pigbench.support.progress import Progress, duration

_SECONDS = 1.0  # spent on measuring each rate


class SuiteEstimate(NamedTuple):
    """Seconds that each unfinished data set and cell will take on its own."""

    data: Mapping[str, float]
    cells: Mapping[SuiteCell, float]


def estimate(suite: Suite, trainings: Trainings, out: Path) -> SuiteEstimate:
    """Estimate the time for the unfinished parts of a suite with these trainings."""
    configs = {(cell.method, cell.variant): one.agent for cell, one in trainings.items()}
    todo = [(cell, steps) for cell, state, steps, _ in status(suite, out) if state != DONE]
    asked = {
        environment: {(c.method, c.variant) for c, _ in todo if c.environment == environment}
        for environment in suite.environments
    }
    total = sum(len(own) + 1 for own in asked.values())
    with Progress("measuring", total=2 * total, unit="turns") as progress:  # one to warm up

        def tell(name: str) -> None:
            progress.advance(1, name)

        update = {
            environment: _updates(environment, configs, own, tell)
            for environment, own in asked.items()
        }
        step = {environment: _step(environment, suite, tell) for environment in asked}
    return SuiteEstimate(
        data={
            environment.name: environment.transitions * step[environment]
            for environment in suite.environments
            if not is_complete(data_folder(environment, out))
        },
        cells={
            cell: (cell.environment.steps - done)
            * (
                update[cell.environment][cell.method, cell.variant]
                + _evaluation_steps(cell.environment, suite)
                * step[cell.environment]
                / suite.evaluation.every
            )
            for cell, done in todo
        },
    )


def table(times: SuiteEstimate, cells: Sequence[Status]) -> list[tuple[str, ...]]:
    """One line per cell, with a header."""
    lines = [
        (cell.name, state, duration(times.cells[cell]) if cell in times.cells else "")
        for cell, state, *_ in cells
    ]
    return [("cell", "state", "time"), *lines]


def summary(times: SuiteEstimate, *, workers: int) -> str:
    """The time in total, and what several trainings at once can save."""
    data, cells = sum(times.data.values()), sum(times.cells.values())
    return (
        f"about {duration(data)} for data and {duration(cells)} for training, one run after "
        f"another; {workers} at once shorten that by a factor of at most {workers}"
    )


def _updates(
    environment: Environment,
    configs: Mapping[tuple[str, str], AgentConfig],
    asked: Collection[tuple[str, str]],
    tell: Callable[[str], object],
) -> Mapping[tuple[str, str], float]:
    """Seconds per update of each requested method and variant."""
    env = envs.make(environment.name)
    rows = training.noise(env)
    contenders = {
        (method, variant): training.updates(
            env, rows, method, configs[method, variant], name=f"{method}+{variant}"
        )
        for method, variant in sorted(asked)
    }
    timings = alternate(list(contenders.values()), turns=1, seconds=_SECONDS, report=tell)
    return {key: timings[contender.name].median for key, contender in contenders.items()}


def _step(environment: Environment, suite: Suite, tell: Callable[[str], object]) -> float:
    """Seconds per control step of one simulation when many run at once."""
    env = envs.make(environment.name, profile=suite.data.physics)
    simulations = env.num_tasks * suite.evaluation.episodes
    contender = simulation.steps(env, simulations, name=environment.name)
    timings = alternate([contender], turns=1, seconds=_SECONDS, report=tell)
    return timings[environment.name].median


def _evaluation_steps(environment: Environment, suite: Suite) -> int:
    """Control steps of one evaluation, if no episode ends early."""
    env = envs.SPECS[environment.name]
    return len(env.tasks) * suite.evaluation.episodes * env.episode_length
