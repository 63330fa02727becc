"""The films that a page shows: a success and a failure of each task, if there are any."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from pigbench.report.stats import Result

OUTCOMES = ("success", "failure")


class Film(NamedTuple):
    """A film of an evaluation episode, labelled with method and seed, after a training step."""

    task: str
    outcome: str
    label: str
    step: int
    path: Path


def choose(results: Sequence[Result]) -> list[Film]:
    """The latest success and failure of each task, by task; of equal steps, the first run's."""
    found: dict[tuple[str, str], Film] = {}
    for film in (film for result in results for film in _of(result)):
        known = found.get((film.task, film.outcome))
        if known is None or film.step > known.step:
            found[film.task, film.outcome] = film
    return [found[key] for key in sorted(found, key=lambda key: (key[0], OUTCOMES.index(key[1])))]


def _of(result: Result) -> Iterator[Film]:
    """The run's films, as written by `evaluation.films`; other files are ignored."""
    config = result.run.config
    for path in sorted(result.run.films_path.glob("*/*.mp4")):
        task, _, outcome = path.stem.rpartition("-")
        if outcome in OUTCOMES and path.parent.name.isdecimal():
            label = f"{config.label}, seed {config.seed}"
            yield Film(task, outcome, label, int(path.parent.name), path)
