"""Which films a page shows: a success and a failure of each task, where there are any."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from pigbench.report.stats import Result

OUTCOMES = ("success", "failure")


class Film(NamedTuple):
    """An evaluation episode of a run, of a method and a seed, after a training step."""

    task: str
    outcome: str
    label: str
    step: int
    path: Path


def choose(results: Sequence[Result]) -> list[Film]:
    """In order of tasks, a success and a failure of each: the latest of the first run with one."""
    found: dict[tuple[str, str], Film] = {}
    for film in (film for result in results for film in _of(result)):
        known = found.get((film.task, film.outcome))
        if known is None or film.step > known.step:
            found[film.task, film.outcome] = film
    return [found[key] for key in sorted(found, key=lambda key: (key[0], OUTCOMES.index(key[1])))]


def _of(result: Result) -> Iterator[Film]:
    """The run's films, as `training.films` writes them."""
    config = result.run.config
    for path in sorted(result.run.films_path.glob("*/*.mp4")):
        task, _, outcome = path.stem.rpartition("-")
        if outcome in OUTCOMES:
            label = f"{config.label}, seed {config.seed}"
            yield Film(task, outcome, label, int(path.parent.name), path)
