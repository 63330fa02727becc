"""The work of a suite in stages, each of which does what is missing: data, training, noise."""

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path

from pigbench import plugins
from pigbench.cluster import Cluster, RemoteProcess
from pigbench.suite import jobs, runner
from pigbench.suite.checks import Trainings, require_same_runs
from pigbench.suite.jobs import Job
from pigbench.suite.logs import last_said, log_path
from pigbench.suite.spec import Suite
from pigbench.suite.status import DONE, Status, is_complete, status, untried, update
from pigbench.support.progress import Progress


def run(
    suite: Suite, out: Path, trainings: Trainings, *, workers: int, cluster: Cluster
) -> list[tuple[str, int]]:
    """Do all stages in the folder `out`, with at most `workers` trainings at once.

    Returns the names and exit statuses of the jobs that failed. Raises UserError if cells were
    trained on other data than have now been generated.
    """
    failed = _generate(suite, out, cluster)
    require_same_runs(suite, out, trainings)
    without = {name for name, _ in failed}
    failed += _train(suite, out, workers, cluster, without=without)
    failed += _try_in_noise(suite, out, workers)
    return failed


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
            progress.advance(0, last_said(out, running))

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
            note = f"{finished} of {len(now)} cells, {last_said(out, running)}"
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
            report=lambda running: progress.advance(0, last_said(out, running)),
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


def _plugins() -> list[str]:
    return [text for file in plugins.loaded_files() for text in ("--plugin", file)]
