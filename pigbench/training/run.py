"""A run's folder: one training run of one method, with all that is needed to trust and repeat it.

config.json       the configuration, which identifies the run
provenance.json   versions, commit, machine and data set, also when resumed with others or extended
statistics.json   mean and deviation of the data's observations, needed to standardise
metrics.jsonl     training metrics (`pigbench.training.metrics`), for trackers' files too
films/STEP/       films of an evaluation, if requested
episodes.csv      every evaluation episode (`pigbench.evaluation.episodes`)
noise/            the same at other noise levels of the cubes' estimates: 5.csv is for 5 mm
checkpoints/      training states
"""

import dataclasses
import itertools
import math
import operator
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from pigbench.agents import stored
from pigbench.errors import UserError
from pigbench.support import files, schema
from pigbench.support.compare import first_difference, require_same

if TYPE_CHECKING:  # tables read runs without agents and JAX
    from pigbench.agents import AgentConfig, Statistics

CONFIG_FILE = "config.json"
PROVENANCE_FILE = "provenance.json"
STATISTICS_FILE = "statistics.json"
EPISODES_FILE = "episodes.csv"
CHECKPOINTS = "checkpoints"
NOISE = "noise"

Keep = Literal["last", "best", "all"]
"""Checkpoints to keep: the last two, these and that of the best evaluation, or all."""

_MAKING = "versions", "commit", "machine", "numerics"
"""The parts of the provenance that results may depend on."""

_BEFORE: Mapping[str, Any] = {"goals": "state", "standardize": False}
"""Values of agents' configuration fields for runs from before the fields existed, where these may
differ from the defaults."""


@dataclasses.dataclass(frozen=True)
class RunConfig:
    """The configuration that identifies a run.

    Attributes:
        method: the method's name in the registry.
        preset: the preset on which `agent` is based.
        agent: every field of the agent's configuration.
        environment: the environment's name.
        physics: the physics profile of the evaluation.
        dataset_digest: the SHA-256 of the data set's manifest.
        steps: the number of updates.
        seed: the seed of the training.
        evaluation: the settings of the evaluation.
        variant: what distinguishes the run from others of its method, if anything.
    """

    method: str
    preset: str
    agent: Mapping[str, Any]
    environment: str
    physics: str
    dataset_digest: str
    steps: int
    seed: int
    evaluation: Mapping[str, Any]
    variant: str = ""

    @property
    def goals(self) -> str:
        """The representation of goals that the agent's networks see."""
        return self.agent.get("goals", _BEFORE["goals"])

    @property
    def engine(self) -> str | None:
        """The physics engine of the run's own evaluations."""
        return self.evaluation.get("engine")

    @property
    def label(self) -> str:
        """The method's name in tables and plots, with the variant if it has one."""
        return f"{self.method} ({self.variant})" if self.variant else self.method


@dataclasses.dataclass(frozen=True)
class Run:
    """A run's folder and configuration."""

    path: Path
    config: RunConfig

    @property
    def episodes_path(self) -> Path:
        """The file of evaluation episodes."""
        return self.path / EPISODES_FILE

    def noise_path(self, millimetres: float) -> Path:
        """The file of episodes in which the cubes' estimates have that noise."""
        return self.path / NOISE / f"{millimetres:g}.csv"

    def noise_paths(self) -> dict[float, Path]:
        """The existing files of such episodes, by millimetres; other files are ignored."""
        found = set((self.path / NOISE).glob("*.csv"))
        levels = sorted(itertools.chain.from_iterable(_numbers(path.stem) for path in found))
        return {level: path for level in levels if (path := self.noise_path(level)) in found}

    @property
    def films_path(self) -> Path:
        """The folder of films, with one folder per evaluated step."""
        return self.path / "films"

    @property
    def checkpoints_path(self) -> Path:
        """The folder of checkpoints."""
        return self.path / CHECKPOINTS

    def saved_steps(self) -> set[int]:
        """The training steps that have a checkpoint."""
        found = self.checkpoints_path.glob("*")
        return {int(path.name) for path in found if path.name.isdecimal()}

    @property
    def is_trained(self) -> bool:
        """Whether the training is finished: its last checkpoint exists."""
        return self.config.steps in self.saved_steps()


def common_step(runs: Sequence[Run]) -> int | None:
    """The last step of which all runs have a checkpoint; None if none has one after step 0.

    Raises UserError if they have no step in common: some would be trained again from the start.
    """
    saved = [run.saved_steps() for run in runs]
    shared = set.intersection(*saved)
    last = [max(steps, default=0) for steps in saved]
    if not shared and any(last):
        apart: dict[int, list[str]] = {}
        for run, step in zip(runs, last, strict=True):
            if not run.is_trained:
                apart.setdefault(step, []).append(str(run.config.seed))
        seeds = " and ".join(f"--seeds {' '.join(group)}" for group in apart.values())
        reached = ", ".join(
            f"{run.config.seed} (step {step:,})" for run, step in zip(runs, last, strict=True)
        )
        raise UserError(
            f"seeds {reached} have no checkpoint in common to go on from together: ask for {seeds}"
        )
    return max(shared, default=None)


def _numbers(text: str) -> list[float]:
    """The number in `text` if it is finite and not negative; nothing otherwise."""
    try:
        number = float(text)
    except ValueError:
        return []
    return [number] if 0 <= number < math.inf else []


def open_run(
    path: Path, config: RunConfig, provenance: Mapping[str, Any], statistics: "Statistics"
) -> Run:
    """Begin the run in the folder `path`, or resume it, extending it if `config` has more steps.

    Raises UserError if the folder contains anything else, or a run whose configuration differs,
    except in having fewer steps.
    """
    if (path / CONFIG_FILE).exists():
        run = read_run(path)
        steps = max(run.config.steps, config.steps)
        longer = Run(path, dataclasses.replace(run.config, steps=steps))
        require_same(str(path), dataclasses.asdict(longer.config), dataclasses.asdict(config))
        if longer != run:
            _extend(longer, {"from_steps": run.config.steps, **provenance})
        return longer
    _require_own(path)
    files.make_folder(path)
    files.write_json(path / PROVENANCE_FILE, provenance)
    content = {name: values.tolist() for name, values in statistics._asdict().items()}
    files.write_json(path / STATISTICS_FILE, files.sealed(content))
    run = Run(path, config)
    _write_config(run)  # last, because it makes the folder a run
    return run


def _write_config(run: Run) -> None:
    files.write_json(run.path / CONFIG_FILE, files.sealed(dataclasses.asdict(run.config)))


def _extend(longer: Run, provenance: Mapping[str, Any]) -> None:
    """Extend a run to more steps; the extension's provenance is kept under its number of steps."""
    kept = files.read_json(longer.path / PROVENANCE_FILE)
    extended = kept.get("extended", {}) | {str(longer.config.steps): provenance}
    files.write_json(longer.path / PROVENANCE_FILE, kept | {"extended": extended})
    _write_config(longer)


def resume(run: Run, provenance: Mapping[str, Any], *, step: int) -> str | None:
    """Record what a run is resumed with after `step` updates, if it differs from before.

    Returns the first difference, in words; None if there is none, or if the run is finished.
    """
    if run.is_trained:
        return None
    path = run.path / PROVENANCE_FILE
    kept = files.read_json(path) if path.exists() else {}
    difference = first_difference(_making(_last(kept)), _making(provenance))
    if difference is None:
        return None
    resumed = kept.get("resumed", {}) | {str(step): provenance}
    files.write_json(path, kept | {"resumed": resumed})
    name, before, now = difference
    return f"{name} was {before!r} and is {now!r}"


def _last(kept: Mapping[str, Any]) -> Mapping[str, Any]:
    """The part of a run's provenance that it was last trained with."""
    later = [
        *((int(step), one) for step, one in kept.get("resumed", {}).items()),
        *((one["from_steps"], one) for one in kept.get("extended", {}).values()),
    ]
    return max(later, key=operator.itemgetter(0), default=(0, kept))[1]


def _making(provenance: Mapping[str, Any]) -> dict[str, Any]:
    return {name: provenance[name] for name in _MAKING if name in provenance}


def _require_own(path: Path) -> None:
    """Raise UserError if the folder contains more than a run interrupted as it began."""
    begun = [path / name for name in (CONFIG_FILE, PROVENANCE_FILE, STATISTICS_FILE)]
    own = {own.name for one in begun for own in (one, files.temporary_path(one))}
    if path.is_dir() and not files.entries(path) <= own:
        raise UserError(f"{path} is not an empty folder and holds no run; choose another")


def read_run(path: Path) -> Run:
    """The run in the folder `path`. Raises UserError if there is none or its config is torn."""
    if not path.is_dir():
        raise UserError(f"{path} does not exist; make a run with `pigbench train`")
    config_path = path / CONFIG_FILE
    if not config_path.exists():
        raise UserError(f"{path} is not a run: it has no {CONFIG_FILE}")
    content = files.read_json(config_path)
    config = schema.read(RunConfig, content, f"{config_path} is torn")
    for name, value in {"agent.goals": config.goals, "evaluation.engine": config.engine}.items():
        if not isinstance(value, str | None):
            raise UserError(f"{config_path} is torn: {name}: {value!r} is not a name")
    return Run(path, dataclasses.replace(config, agent=stored.upgraded(config.agent)))


def read_statistics(run: Run) -> "Statistics | None":
    """The statistics of the data from which the run learns; None for old runs without any."""
    from pigbench.agents import Statistics

    path = run.path / STATISTICS_FILE
    if not path.exists():
        return None
    content = files.read_json(path)
    with files.explaining_torn(path):
        return Statistics(
            **{name: np.asarray(values, np.float32) for name, values in content.items()}
        )


def agent_config(run: Run) -> "AgentConfig":
    """The run's agent configuration. Raises UserError if it does not fit the method."""
    from pigbench import agents

    template = agents.get(run.config.method).config
    before = {name: value for name, value in _BEFORE.items() if hasattr(template, name)}
    what = f"{run.path / CONFIG_FILE} holds no configuration of {run.config.method!r}"
    return schema.fill(template, {**before, **run.config.agent}, what)
