"""`pigbench suite`: many training runs as one job."""

import dataclasses
import itertools
import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

import tyro

from pigbench import cli, envs, plugins
from pigbench.agents import AgentConfig
from pigbench.cluster import Cluster, RemoteProcess
from pigbench.commands.report import order, write_page
from pigbench.commands.suite_status import print_status
from pigbench.data import manifest
from pigbench.errors import UserError, lookup
from pigbench.report import plots, stats, tables
from pigbench.report.formats import markdown_grid
from pigbench.report.stats import Result
from pigbench.suite import estimate, jobs, runner, spec
from pigbench.suite.jobs import Job
from pigbench.suite.spec import Environment, Suite
from pigbench.suite.status import (
    DONE,
    Status,
    is_complete,
    last_lines,
    log_path,
    status,
    untried,
    update,
)
from pigbench.support import files
from pigbench.support.compare import require_same
from pigbench.support.lock import only_writer
from pigbench.support.progress import Progress, duration
from pigbench.training.run import read_run

_LAST_LINES = 3
_PAGE = "report"
_FORMATS = {"markdown": "md", "latex": "tex", "csv": "csv"}


@dataclasses.dataclass(frozen=True)
class RunSuite:
    """Generate, train, evaluate, tabulate, plot and report everything that a suite file asks for.

    If the command was interrupted, run it again: finished work is skipped, and interrupted work
    continues. A cell that fails does not stop the others.
    """

    file: tyro.conf.Positional[Path]
    """A TOML file, or the name of a suite that comes with pigbench."""
    out: Path
    """Folder of the suite's data, runs, logs, tables, figures and page."""
    jobs: int = os.cpu_count() or 1
    """Training runs at once; if there are several, each gets one processor thread."""
    cluster: Annotated[Cluster, tyro.conf.arg(name="")] = dataclasses.field(default_factory=Cluster)
    """Where shards are simulated and cells are trained."""
    dry_run: bool = False
    """Only print the cells and the time they will take, by rates measured now."""

    def run(self) -> None:
        """Do the work that is not done yet."""
        if self.jobs < 1:
            raise UserError(f"jobs is {self.jobs}: it must be at least 1")
        suite = spec.read(self.file)
        configs = _check(suite, self.out)
        if (self.out / spec.KEPT).exists():
            _require_compatible(self.out, suite)
        if self.dry_run:
            _print_plan(suite, self.out, estimate.estimate(suite, configs, self.out), self.jobs)
            return
        with only_writer(self.out):
            spec.write(self.out / spec.KEPT, suite)
            failed = _generate(suite, self.out, self.cluster)
            without = {name for name, _ in failed}
            failed += _train(suite, self.out, self.jobs, self.cluster, without=without)
            failed += _try_in_noise(suite, self.out, self.jobs)
            print_status(suite, self.out)
            _report(suite, self.out)
            _write_page(self.out)
        if failed:
            _explain(failed, self.out)
            sys.exit(1)


def _check(suite: Suite, out: Path) -> Mapping[tuple[str, str], AgentConfig]:
    """The hyper-parameters of each method and variant.

    Raises UserError for anything that the suite's commands would reject.
    """
    for environment in suite.environments:
        lookup("environment", envs.SPECS, environment.name)
        _check_data(suite, environment, out)
        for job in jobs.preparation(suite, environment, out):
            cli.parse(job.arguments)
    return {
        (cell.method, cell.variant): cli.parse(jobs.training(suite, cell, out).arguments).agent
        for cell in suite.cells()
    }


def _check_data(suite: Suite, environment: Environment, out: Path) -> None:
    """Raise UserError if an existing data set is of another environment or physics profile."""
    folder = jobs.data_folder(environment, out)
    if (folder / manifest.FILE_NAME).exists():
        stored = manifest.read(folder).spec
        asked = {"environment": environment.name, "physics": suite.data.physics}
        require_same(str(folder), {name: getattr(stored, name) for name in asked}, asked)


def _require_compatible(out: Path, suite: Suite) -> None:
    """Raise UserError unless `suite` extends the one kept in the folder `out`.

    A suite may grow along its axes, train longer and change its noise levels; the other settings
    its cells share must stay.
    """
    kept = spec.read_kept(out / spec.KEPT)
    asked = {environment.name: environment.steps for environment in suite.environments}
    for environment in kept.environments:
        if asked.get(environment.name, environment.steps) < environment.steps:
            raise UserError(
                f"{out} trains {environment.steps:,} steps on {environment.name}, and not fewer: "
                "ask for as many or more, or choose another folder"
            )
    stored, wanted = (_settings(kept), _settings(suite))
    common = {key for key in stored if key in wanted}
    require_same(
        str(out),
        {key: stored[key] for key in sorted(common)},
        {key: wanted[key] for key in sorted(common)},
    )


def _settings(suite: Suite) -> dict[str, object]:
    settings: dict[str, object] = {
        "preset": suite.preset,
        "data": dataclasses.asdict(suite.data),
        "evaluation": {"every": suite.evaluation.every, "episodes": suite.evaluation.episodes},
        "agent": suite.agent,
    }
    for environment in suite.environments:
        settings[environment.name] = {
            "transitions": environment.transitions,
            "data": str(environment.data),
        }
    return settings | {f"variants.{name}": fields for name, fields in suite.variants.items()}


def _generate(suite: Suite, out: Path, cluster: Cluster) -> list[tuple[str, int]]:
    """Make the missing data sets, one after another: each uses all cores."""
    todo = [
        _on(cluster, job)
        for environment in suite.environments
        if not is_complete(jobs.data_folder(environment, out))
        for job in jobs.preparation(suite, environment, out)
    ]
    if not todo:
        return []
    with Progress("data sets", total=len(todo), unit="data sets") as progress:

        def tell(running: Sequence[str]) -> None:
            progress.advance(0, _last_said(out, running))

        failed = _run(todo, out, workers=1, report=tell)
        progress.reach(len(todo))
    return failed


def _on(cluster: Cluster, job: Job) -> Job:
    """The job with the cluster's arguments, if it takes them."""
    if job.arguments[0] != "generate":
        return job
    return dataclasses.replace(job, arguments=(*job.arguments, *cluster.arguments))


def _train(
    suite: Suite, out: Path, workers: int, cluster: Cluster, *, without: set[str]
) -> list[tuple[str, int]]:
    """Train and evaluate the cells that are not done and have their data."""
    now = status(suite, out)
    todo = [
        jobs.training(suite, cell, out)
        for cell, state, *_ in now
        if state != DONE and jobs.data_job(cell.environment) not in without
    ]
    total = sum(one.cell.environment.steps for one in now)
    with Progress("suite", total=total, unit="updates", done=_done(now)) as progress:

        def tell(running: Sequence[str]) -> None:
            nonlocal now
            now = update(now, out)
            finished = sum(one.state == DONE for one in now)
            note = f"{finished} of {len(now)} cells, {_last_said(out, running)}"
            progress.reach(_done(now), note)

        if cluster.ray is None or not todo:
            return _run(todo, out, workers=workers, report=tell)
        with cluster.connected() as tasks:  # the cluster limits how many run at once
            start = partial(RemoteProcess, tasks)
            return _run(todo, out, workers=len(todo), report=tell, start=start)


def _try_in_noise(suite: Suite, out: Path, workers: int) -> list[tuple[str, int]]:
    """Evaluate finished cells under the noise levels that their last policy lacks."""
    done = [one.cell for one in status(suite, out) if one.state == DONE]
    todo = [
        jobs.noise(suite, cell, out, levels)
        for cell in done
        if (levels := untried(suite, cell, out))
    ]
    if not todo:
        return []
    with Progress("noise", total=len(todo), unit="cells") as progress:
        failed = _run(
            todo,
            out,
            workers=workers,
            report=lambda running: progress.advance(0, _last_said(out, running)),
        )
        progress.reach(len(todo))
    return failed


def _run(
    todo: Iterable[Job],
    out: Path,
    *,
    workers: int,
    report: Callable[[Sequence[str]], object],
    start: runner.Start | None = None,
) -> list[tuple[str, int]]:
    """Run jobs of the suite in `out`; returns names and exit statuses of those that failed."""
    ended = runner.run(
        todo,
        workers=workers,
        log=lambda name: log_path(out, name),
        options=_plugins(),
        report=report,
        start=start,
    )
    return [(name, code) for name, code in ended.items() if code]


def _done(cells: Iterable[Status]) -> int:
    return sum(one.steps for one in cells)


def _last_said(out: Path, running: Sequence[str]) -> str:
    lines = (last_lines(log_path(out, name), 1) for name in running)
    said = (line[0].split(",")[0] if line else "starting" for line in lines)
    return "; ".join(f"{name}: {text}" for name, text in zip(running, said, strict=True))


def _plugins() -> list[str]:
    return [text for file in plugins.loaded_files() for text in ("--plugin", file)]


def _print_plan(suite: Suite, out: Path, times: estimate.Estimate, workers: int) -> None:
    lines = [
        (cell.name, state, duration(times.cells[cell]) if cell in times.cells else "")
        for cell, state, *_ in status(suite, out)
    ]
    print(markdown_grid([("cell", "state", "time"), *lines]))
    data, cells = sum(times.data.values()), sum(times.cells.values())
    print(
        f"\nabout {duration(data)} for data and {duration(cells)} for training, one run after "
        f"another; {workers} at once shorten that by a factor of at most {workers}"
    )


def _explain(failed: Iterable[tuple[str, int]], out: Path) -> None:
    for name, code in failed:
        log = log_path(out, name)
        print(f"\n{name} failed with exit status {code}; the end of {log}:", file=sys.stderr)
        for line in last_lines(log, _LAST_LINES + 1)[:-1]:
            print(f"  {line}", file=sys.stderr)


def _report(suite: Suite, out: Path) -> None:
    """Write tables and figures of the finished cells."""
    runs = [out / one.cell.name for one in status(suite, out) if one.state == DONE]
    if not runs:
        return
    results = stats.read_results(read_run(run) for run in runs)
    telling = tables.telling(results)
    made = [tables.TABLES[name](results, order=order()) for name in telling]
    for style, extension in _FORMATS.items():
        files.write_text(out / f"tables.{extension}", tables.render_all(made, style))
    fits = {
        "columns": _has_low_levels(results),
        **dict.fromkeys(("box", "profile"), "aggregate" in telling),
    }
    kinds = [kind for kind in plots.KINDS if fits.get(kind, True)]
    for kind, extension in itertools.product(kinds, ("png", "pdf")):
        plots.plot(results, out / f"{kind}.{extension}", kind=kind, order=order())
    print(f"wrote tables and figures to {out}")


def _write_page(out: Path) -> None:
    try:
        print(f"{write_page([out], out / _PAGE)} shows them")
    except (UserError, OSError) as error:  # the suite is complete without it
        print(f"no page was written: {error}")


def _has_low_levels(results: Iterable[Result]) -> bool:
    return any(result.representation is not None for result in results)
