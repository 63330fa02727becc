"""A run's folder: one training run of one method, with all that is needed to trust and repeat it.

config.json       the configuration, which identifies the run
provenance.json   versions, commit, machine and data set, also when resumed with others or extended
statistics.json   mean and deviation of the data's observations, needed to standardise
metrics.jsonl     training metrics (`pigbench.runs.metrics`)
tensorboard/      the same and success rates, for TensorBoard; other trackers have their own files
films/STEP/       films of an evaluation, if requested
episodes.csv      every evaluation episode (`pigbench.evaluation.episodes`)
noise/            the same at other noise levels of the cubes' estimates: 5.csv is for 5 mm
checkpoints/      training states
analysis/         what `analyze` and `subgoals` measured
wandb-id          the run's id in Weights & Biases, if it is shown there
.lock             held by the process that writes
"""

import dataclasses
import itertools
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from pigbench.errors import UserError
from pigbench.runs import history
from pigbench.runs.statistics import write_statistics
from pigbench.support import files, schema
from pigbench.support.compare import require_same

if TYPE_CHECKING:  # tables read runs without agents and JAX
    from pigbench.agents import Statistics

CONFIG_FILE = "config.json"
PROVENANCE_FILE = "provenance.json"
STATISTICS_FILE = "statistics.json"
EPISODES_FILE = "episodes.csv"
CHECKPOINTS = "checkpoints"
NOISE = "noise"

Keep = Literal["last", "best", "all"]
"""Checkpoints to keep: the last two, these and that of the best evaluation, or all."""


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
        return self.agent["goals"]

    @property
    def engine(self) -> str:
        """The physics engine of the run's own evaluations."""
        return self.evaluation["engine"]

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
    def provenance_path(self) -> Path:
        """The file that says what the run was made with."""
        return self.path / PROVENANCE_FILE

    @property
    def statistics_path(self) -> Path:
        """The file with the statistics of the data."""
        return self.path / STATISTICS_FILE

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
        levels = sorted(itertools.chain.from_iterable(_noise_level(path.stem) for path in found))
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


def _noise_level(text: str) -> list[float]:
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
        require_continues(run, config)
        longer = Run(path, dataclasses.replace(run.config, steps=config.steps))
        if longer != run:
            history.record_extension(
                run.provenance_path, provenance, from_steps=run.config.steps, steps=config.steps
            )
            _write_config(longer)
        return longer
    _require_own(path)
    files.make_folder(path)
    run = Run(path, config)
    files.write_json(run.provenance_path, provenance)
    write_statistics(run.statistics_path, statistics)
    _write_config(run)  # last, because it makes the folder a run
    return run


def require_continues(
    run: Run, config: RunConfig, *, otherwise: str = "choose another folder"
) -> None:
    """Raise UserError unless `config` is that of the run, but for more steps.

    The error says what to do `otherwise` than to ask for what the run has.
    """
    steps = max(run.config.steps, config.steps)
    stored = dataclasses.asdict(dataclasses.replace(run.config, steps=steps))
    require_same(str(run.path), stored, dataclasses.asdict(config), otherwise=otherwise)


def _write_config(run: Run) -> None:
    files.write_sealed(run.path / CONFIG_FILE, dataclasses.asdict(run.config))


def _require_own(path: Path) -> None:
    """Raise UserError if the folder contains more than a run interrupted as it began."""
    begun = [path / name for name in (CONFIG_FILE, PROVENANCE_FILE, STATISTICS_FILE)]
    own = {own.name for one in begun for own in (one, files.temporary_path(one))}
    if path.is_dir() and not files.entries(path) <= own:
        raise UserError(f"{path} is not an empty folder and holds no run; choose another")


def read_run(path: Path) -> Run:
    """The run in the folder `path`. Raises UserError if there is none or its config is invalid."""
    if not path.is_dir():
        raise UserError(f"{path} does not exist; make a run with `pigbench train`")
    config_path = path / CONFIG_FILE
    if not config_path.exists():
        raise UserError(f"{path} is not a run: it has no {CONFIG_FILE}")
    config = schema.read(RunConfig, files.read_sealed(config_path), f"{config_path} is invalid")
    for part, name in {"agent": "goals", "evaluation": "engine"}.items():
        value = getattr(config, part).get(name)
        if not isinstance(value, str):
            raise UserError(f"{config_path} is invalid: {part}.{name}: {value!r} is not a name")
    return Run(path, config)
