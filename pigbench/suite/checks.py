"""What a suite is refused for: commands that cannot run, and what exists and was made otherwise."""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pigbench import envs
from pigbench.data import manifest
from pigbench.data.manifest import Spec
from pigbench.errors import UserError
from pigbench.runs.run import Run, read_run, require_continues
from pigbench.suite import jobs
from pigbench.suite.spec import Environment, Suite, SuiteCell
from pigbench.suite.status import is_complete
from pigbench.support.compare import require_same

Parse = Callable[[Sequence[str]], Any]
"""The command that arguments ask for. Raises UserError for what it rejects."""

Trainings = Mapping[SuiteCell, Any]
"""The command that trains each cell."""


def checked_trainings(suite: Suite, out: Path, parse: Parse) -> Trainings:
    """The trainings of a suite that is checked as a whole, with all that exists in `out`.

    Raises UserError for anything that the suite's commands would reject, and for a data set or a
    run that was made otherwise than the suite asks for.
    """
    for environment in suite.environments:
        envs.get(environment.name)
        _require_same_data(suite, environment, out, parse)
    trainings = {cell: parse(jobs.training(suite, cell, out).arguments) for cell in suite.cells()}
    require_same_runs(suite, out, trainings)
    return trainings


def require_same_runs(suite: Suite, out: Path, trainings: Trainings) -> None:
    """Raise UserError if a cell's run, finished or not, is not the one that the suite asks for.

    It may have fewer steps. A run whose data are missing is taken to be of those to be generated.
    """
    digests = {
        environment: manifest.digest(folder)
        for environment in suite.environments
        if is_complete(folder := jobs.data_folder(environment, out))
    }
    for cell, training in trainings.items():
        run = _existing(out / cell.name)
        if run is not None:
            here = dataclasses.replace(training, engine=run.config.engine)  # each machine has its
            config = here.config(
                cell.seed,
                environment=cell.environment.name,
                physics=suite.data.physics,
                dataset_digest=digests.get(cell.environment, run.config.dataset_digest),
            )
            require_continues(run, config, otherwise="choose another --out or name of a variant")


def _existing(folder: Path) -> Run | None:
    """The run in the folder; None if there is none, or a torn one, on which its cell will fail."""
    try:
        return read_run(folder)
    except UserError:
        return None


def _require_same_data(suite: Suite, environment: Environment, out: Path, parse: Parse) -> None:
    """Raise UserError if an existing data set is not what the suite asks for.

    One in the suite's own folder must be what its commands make. One that the suite names may be of
    any size and origin, but must not contradict the fields that the file gives.
    """
    preparation = jobs.preparation(suite, environment, out)
    generate, *_ = (parse(job.arguments) for job in preparation)
    asked = {
        "environment": environment.name,
        **suite.data.model_dump(include={"physics", "policy", "seed", "compact"}),
    }
    size = {"episodes": generate.split_episodes, "rows_per_episode": generate.rows_per_episode}
    results = asked | {"filter": False} | size, asked | {"filter": True}
    for job, result in zip(preparation, results, strict=False):
        if (job.folder / manifest.FILE_NAME).exists():
            if environment.data is not None:
                binding = {"environment", "physics", *suite.data.model_fields_set}
                result = {name: value for name, value in result.items() if name in binding}
            stored = _described(manifest.read(job.folder).spec)
            require_same(str(job.folder), {name: stored[name] for name in result}, result)


def _described(spec: Spec) -> dict[str, Any]:
    """An existing data set in the words of a suite, and its size."""
    return {
        "environment": spec.environment,
        "physics": spec.physics,
        "policy": spec.policy,
        "seed": spec.seed,
        "compact": spec.is_compact,
        "filter": spec.is_filtered,
        "episodes": spec.episodes,
        "rows_per_episode": spec.rows_per_episode,
    }
