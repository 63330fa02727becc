"""What a suite is refused for before any of its work begins."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from pigbench import envs
from pigbench.agents.config import AgentConfig
from pigbench.data import manifest
from pigbench.suite import jobs
from pigbench.suite.spec import Environment, Suite
from pigbench.support.compare import require_same

Parse = Callable[[Sequence[str]], Any]
"""The command that arguments ask for. Raises UserError for what it rejects."""


def checked_configurations(
    suite: Suite, out: Path, parse: Parse
) -> Mapping[tuple[str, str], AgentConfig]:
    """The hyperparameters of each method and variant, of a suite that is checked as a whole.

    Raises UserError for anything that the suite's commands would reject.
    """
    for environment in suite.environments:
        envs.get(environment.name)
        _require_same_data(suite, environment, out)
        for job in jobs.preparation(suite, environment, out):
            parse(job.arguments)
    return {
        (cell.method, cell.variant): parse(jobs.training(suite, cell, out).arguments).agent
        for cell in suite.cells()
    }


def _require_same_data(suite: Suite, environment: Environment, out: Path) -> None:
    """Raise UserError if an existing data set is of another environment or physics profile."""
    folder = jobs.data_folder(environment, out)
    if (folder / manifest.FILE_NAME).exists():
        stored = manifest.read(folder).spec
        asked = {"environment": environment.name, "physics": suite.data.physics}
        require_same(str(folder), {name: getattr(stored, name) for name in asked}, asked)
