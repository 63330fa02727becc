"""A data set of the good episodes of another, with a report of what was left out and why."""

import dataclasses
import itertools
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from pigbench import envs
from pigbench.data import quality
from pigbench.data.dataset import Dataset, Split
from pigbench.data.manifest import FILTERED_BY, Spec
from pigbench.data.quality import CRITERIA, Limits
from pigbench.data.shard import FieldArray
from pigbench.data.writer import Writer
from pigbench.errors import UserError
from pigbench.layout import Layout
from pigbench.support import files
from pigbench.support.lock import only_writer
from pigbench.support.progress import Progress

REPORT = "filter.json"
"""The file beside the manifest that lists every episode that was left out."""


class Judged(NamedTuple):
    """An episode: rows of a split's shard, their measures, and the criteria that it fails."""

    split: str
    shard: int
    start: int
    stop: int
    measures: Mapping[str, float]
    fails: tuple[str, ...]

    @property
    def rows(self) -> int:
        """The episode's number of rows."""
        return self.stop - self.start


def judge(dataset: Dataset, criteria: Collection[str], limits: Limits) -> list[Judged]:
    """Judge every episode of the data set by the named criteria.

    Raises UserError for an unknown name, a limit of another criterion, or a data set whose episodes
    cannot be judged.
    """
    quality.check(criteria, limits)
    spec = envs.get(dataset.spec.environment)
    if len(spec.tasks) != 1 or spec.num_cubes != 1:
        raise UserError(
            f"{dataset.folder} is of {spec.name}: episodes are judged by the only goal of one "
            "cube, as cube-centre has it"
        )
    goal = spec.tasks[0].goal_xyz[0]
    splits = [dataset.split(name) for name, count in dataset.spec.episodes.items() if count]
    total = sum(len(split.records) for split in splits)
    judged = []
    with Progress("judging", total=total, unit="shards") as progress:
        for split in splits:
            for number, record in enumerate(split.records):
                judged += _judge(split, number, dataset.layout, goal, criteria, limits)
                progress.advance(1, record.name)
    return judged


def write(
    dataset: Dataset,
    folder: Path,
    judged: Collection[Judged],
    criteria: Collection[str],
    limits: Limits,
) -> None:
    """Write the episodes that fail no criterion, in order; shards already written are kept.

    Raises UserError if no episode of the training split is left.
    """
    kept = [one for one in judged if not one.fails]
    if not any(one.split == "train" for one in kept):
        raise UserError(f"no training episode of {dataset.folder} passes {', '.join(criteria)}")
    files.require_folder(folder)
    parts = {
        (split, number): list(episodes)
        for (split, number), episodes in itertools.groupby(kept, lambda one: (one.split, one.shard))
    }
    filtered = "; ".join(f"{name} {CRITERIA[name].limit(limits)}" for name in criteria)
    spec = _spec(dataset, parts, filtered)
    with only_writer(folder):
        writer = Writer(folder, spec)
        todo = set(writer.missing())
        with Progress("filter", total=len(todo), unit="shards") as progress:
            for shard, episodes in zip(spec.plan(), _ordered(parts), strict=True):
                if shard in todo:
                    writer.write(shard, _rows(dataset.split(shard.split), episodes, spec))
                    progress.advance(1, shard.name)


def table(
    judged: Collection[Judged], criteria: Collection[str], limits: Limits
) -> list[tuple[str, ...]]:
    """What each criterion leaves out, as lines of cells, header first."""

    def line(name: str) -> tuple[str, ...]:
        failing = [one for one in judged if name in one.fails]
        alone = sum(one.fails == (name,) for one in failing)
        rows = sum(one.rows for one in failing)
        return name, CRITERIA[name].limit(limits), f"{len(failing):,}", f"{alone:,}", f"{rows:,}"

    header = ("criterion", "kept if", "episodes that fail", "by it alone", "rows")
    return [header, *map(line, criteria)]


def summary(judged: Collection[Judged]) -> str:
    """A line that says what is kept."""
    total, kept = sum(one.rows for one in judged), [one for one in judged if not one.fails]
    rows = sum(one.rows for one in kept)
    return (
        f"kept: {len(kept):,} of {len(judged):,} episodes, {rows:,} of {total:,} rows "
        f"({100 * rows / total:.0f} %)"
    )


def write_report(
    folder: Path, dataset: Dataset, judged: Collection[Judged], limits: Limits
) -> None:
    """Write the measures of every episode that was left out to a file beside the manifest."""
    content = {
        "of": dataset.digest,
        "limits": dataclasses.asdict(limits),
        "kept": sum(not one.fails for one in judged),
        "dropped": [
            {
                "split": one.split,
                "shard": one.shard,
                "first row": one.start,
                "rows": one.rows,
                "fails": one.fails,
                **{name: _number(value) for name, value in one.measures.items()},
            }
            for one in judged
            if one.fails
        ],
    }
    files.write_json(folder / REPORT, content)


def _judge(
    split: Split,
    number: int,
    layout: Layout,
    goal: Float[np.ndarray, "3"],
    criteria: Collection[str],
    limits: Limits,
) -> Iterator[Judged]:
    """Judge the episodes of one shard."""
    record = split.records[number]
    observations = split.shard(record, "observations")
    ends = np.flatnonzero(split.shard(record, "terminals")) + 1
    for start, stop in itertools.pairwise([0, *map(int, ends)]):
        episode = quality.episode(np.asarray(observations[start:stop]), layout, goal)
        measures = quality.measure(episode, limits)
        fails = (name for name in criteria if not CRITERIA[name].good(measures[name], limits))
        yield Judged(record.split, number, start, stop, measures, tuple(fails))


def _spec(
    dataset: Dataset, parts: Mapping[tuple[str, int], Collection[Judged]], filtered: str
) -> Spec:
    """The source's specification, except for the numbers of episodes, and with its origin."""
    counts = {
        split: tuple(len(episodes) for (own, _), episodes in sorted(parts.items()) if own == split)
        for split in dataset.spec.episodes
    }
    return dataclasses.replace(
        dataset.spec,
        episodes={split: sum(sizes) for split, sizes in counts.items()},
        episodes_per_shard=counts,
        origin={
            **dataset.spec.origin,
            FILTERED_BY: filtered,
            "of the data": f"SHA-256 {dataset.digest}",
        },
    )


def _ordered(parts: Mapping[tuple[str, int], list[Judged]]) -> list[list[Judged]]:
    """The parts in the order of a plan's shards: by split, then by number."""
    return [episodes for _, episodes in sorted(parts.items())]


def _rows(split: Split, episodes: Collection[Judged], spec: Spec) -> dict[str, FieldArray]:
    (number,) = {one.shard for one in episodes}
    taken = np.concatenate([np.arange(one.start, one.stop) for one in episodes])
    record = split.records[number]
    return {field: split.shard(record, field)[taken] for field in spec.fields}


def _number(value: float) -> float | None:
    return value if np.isfinite(value) else None
