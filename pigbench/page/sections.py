"""A page's sections, one per environment."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from pigbench.page import figures, films
from pigbench.page.figures import Json
from pigbench.page.films import Film
from pigbench.page.looks import Look
from pigbench.report import tables
from pigbench.report.formats import Table
from pigbench.report.order import ordered
from pigbench.report.scoring import (
    Scoring,
    by_stage,
    by_task,
    curve_remarks,
    score_remarks,
    wording,
)
from pigbench.report.stats import Result
from pigbench.support.grouping import grouped

TABLES = ("tasks", "milestones", "thresholds")
"""Tables from `tables.TABLES` that concern tasks, or whose rows are an environment's methods."""


class Figure(NamedTuple):
    """A figure that Bokeh's script draws."""

    title: str
    caption: str
    json: Json


@dataclass(frozen=True)
class Section:
    """Figures, tables and films of one environment; films are keyed by file name."""

    environment: str
    figures: Sequence[Figure]
    tables: Mapping[str, Table]
    films: Mapping[str, Film]


def sections(
    done: Sequence[Result],
    unfinished: Sequence[Result],
    order: Sequence[str],
    scoring: Scoring,
    looks: Mapping[str, Look],
) -> list[Section]:
    """One section per environment, in order. Unfinished runs appear only in curves and films.

    Takes results as given by `Scoring.only_counted`. Raises UserError if the finished runs are not
    comparable.
    """
    mine = grouped(done, _environment)
    going_on = grouped(unfinished, _environment)
    return [
        _section(
            environment,
            mine.get(environment, []),
            going_on.get(environment, []),
            order,
            scoring,
            looks,
        )
        for environment in ordered({*mine, *going_on}, order)
    ]


def _section(
    environment: str,
    done: Sequence[Result],
    unfinished: Sequence[Result],
    order: Sequence[str],
    scoring: Scoring,
    looks: Mapping[str, Look],
) -> Section:
    return Section(
        environment,
        list(_figures(done, unfinished, order, scoring, looks)),
        _tables(done, order, scoring),
        {
            f"{environment}-{film.task}-{film.outcome}.mp4": film
            for film in films.choose([*done, *unfinished])
        },
    )


def _figures(
    done: Sequence[Result],
    unfinished: Sequence[Result],
    order: Sequence[str],
    scoring: Scoring,
    looks: Mapping[str, Look],
) -> Iterable[Figure]:
    finished = _by_method(done, order)
    told = "".join(f"; {remark}" for remark in curve_remarks([*done, *unfinished]))
    yield Figure(
        "Success over training",
        f"Mean over seeds, in a band of one standard deviation to each side{told}."
        + (" Faint: unfinished runs, one by one." if unfinished else ""),
        figures.curves(finished, _by_method(unfinished, order), looks),
    )
    if finished:
        cells = scoring.cells(done)
        evaluated = wording(cells, scoring).capitalize()
        told = "".join(f"; {remark}" for remark in score_remarks(cells, scoring))
        how = f"{evaluated}; whiskers: one standard deviation over seeds{told}."
        for title, groups, quantity in (
            ("Success on each task", by_task, "success (%)"),
            ("How far episodes got", by_stage, "episodes (%)"),
        ):
            found = {method: groups(group, scoring) for method, group in finished.items()}
            yield Figure(title, how, figures.bars(found, quantity, looks))


def _tables(done: Sequence[Result], order: Sequence[str], scoring: Scoring) -> dict[str, Table]:
    if not done:
        return {}
    return {name: tables.TABLES[name].make(done, order=order, scoring=scoring) for name in TABLES}


def _by_method(results: Sequence[Result], order: Sequence[str]) -> dict[str, list[Result]]:
    groups = grouped(results, lambda result: result.run.config.label)
    return {method: groups[method] for method in ordered(groups, order)}


def _environment(result: Result) -> str:
    return result.run.config.environment
