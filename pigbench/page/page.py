"""The page's file: its content in a template, with all scripts and styles included."""

import json
import re
import shutil
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import jinja2
from bokeh.resources import Resources
from markupsafe import Markup

from pigbench.errors import UserError
from pigbench.page import entries, place, records
from pigbench.page.looks import looks
from pigbench.page.sections import TABLES, Section, sections
from pigbench.report import tables
from pigbench.report.bootstrap import LEVEL
from pigbench.report.order import ordered
from pigbench.report.scoring import Scoring
from pigbench.report.stats import Result
from pigbench.support import files

_HERE = Path(__file__).parent
_HEADLINE = "methods"


def write(
    folders: Sequence[Path], out: Path, *, order: Sequence[str] = (), scoring: Scoring | None = None
) -> Path:
    """Write the page of runs and suites into the folder `out`, with its films; returns its file.

    Raises UserError if there are none, if the finished ones are not comparable, and like
    `place.replacing`.
    """
    found = entries.read(folders)
    if not found:
        raise UserError("no runs are given: name the folders of one or more, or of a suite")
    scoring = scoring or Scoring()
    done = [scoring.only_counted(entry.result) for entry in found if entry.done and entry.result]
    unfinished = [
        scoring.only_counted(entry.result) for entry in found if not entry.done and entry.result
    ]
    methods = {result.run.config.label for result in [*done, *unfinished]}
    shown = looks(methods)
    told = sections(done, unfinished, order, scoring, shown)
    made = {
        name: tables.TABLES[name].make(done, order=order, scoring=scoring)
        for name in _overall(done, environments=len(told))
    }
    runs = [entry.saved.run for entry in found if entry.saved]
    configurations = records.configurations(runs, order)
    text = _render(
        title=", ".join(_titles(folders, told)),
        entries=found,
        level=LEVEL,
        looks={method: shown[method] for method in ordered(methods, order)},
        headline=made.pop(_HEADLINE, None),
        tables=made,
        sections=told,
        compared=records.compared(configurations),
        configurations=configurations,
        provenance=records.provenance(runs),
        commands=records.commands(folders),
    )
    with place.replacing(out) as folder:
        files.write_text(folder / place.PAGE, text)
        _copy_films(told, folder / place.FILMS)
    return out / place.PAGE


def _overall(done: Sequence[Result], *, environments: int) -> list[str]:
    """The names of the tables that are shown for all environments together, in order."""
    elsewhere = {*TABLES} if environments > 1 else {*TABLES, "aggregate"}  # it is over environments
    return [name for name in tables.fillable(done) if name not in elsewhere] if done else []


def _titles(folders: Sequence[Path], told: Sequence[Section]) -> list[str]:
    """The names of the suites, or else of the environments."""
    suites = [folder.resolve().name for folder in folders if entries.is_suite(folder)]
    return suites or [section.environment for section in told] or ["runs"]


def _render(**content: Any) -> str:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_HERE),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    # Bokeh depends on the order of an object's fields, which Jinja's defaults do not keep.
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":")}
    environment.tests["digest"] = re.compile(r"[0-9a-f]{40,}").fullmatch
    environment.filters |= {
        "breakable": _breakable,
        "json_text": partial(json.dumps, indent=1),
        "plain": _plain,
    }
    bokeh = Resources(mode="inline", components=["bokeh"], log_level="warn")
    return environment.get_template("page.html").render(bokeh="\n".join(bokeh.js_raw), **content)


def _copy_films(told: Sequence[Section], folder: Path) -> None:
    for section in told:
        for name, film in section.films.items():
            folder.mkdir(exist_ok=True)
            shutil.copyfile(film.path, folder / name)


def _breakable(name: str) -> Markup:
    """A dotted name or a path in which a line may break after a dot or a slash."""
    return Markup("<wbr>").join(re.split(r"(?<=[./])", name))


def _plain(value: Any) -> str:
    """A value of a configuration for readers: text without quotes, a dash for None."""
    if value is None:
        return "–"
    return value if isinstance(value, str) else json.dumps(value)
