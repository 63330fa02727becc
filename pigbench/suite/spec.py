"""A suite file: environments, methods, variants and seeds; the product of these is the cells."""

import dataclasses
import itertools
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import pydantic

from pigbench import names
from pigbench.data.defaults import EPISODE_ROWS, HomeChoice
from pigbench.errors import UserError
from pigbench.runs.run import Keep
from pigbench.seeds import Seed
from pigbench.support import files, schema
from pigbench.support.compare import flatten

KEPT = "suite.json"
"""The file in a suite's folder in which `write` keeps it."""

READY = Path(__file__).parent / "ready"
"""The folder of the suites that come with the package."""

Count = Annotated[int, pydantic.Field(ge=1)]
Noise = Annotated[float, pydantic.Field(ge=0, allow_inf_nan=False)]


@dataclass(frozen=True)
class Environment:
    """An environment, the size of its training data, and how long methods train on it."""

    name: str
    transitions: Count
    steps: Count
    data: Path | None = None  # folder of the data set; by default in the suite's own


class Data(pydantic.BaseModel, frozen=True):
    """How missing data sets are generated.

    It is a model, and no dataclass, to know which fields were given (`model_fields_set`): data
    sets that the file names must not contradict these.
    """

    policy: str = "play"
    physics: str = "exact"
    seed: Seed = 0
    validation_episodes: Annotated[int, pydantic.Field(ge=0)] | None = None
    episode_transitions: Count = EPISODE_ROWS - 1  # from which the number of episodes is computed
    compact: bool = False  # without qpos and qvel, which no method trains on: half the room
    filter: bool = False  # whether only good episodes are kept, by `pigbench data filter`


@dataclass(frozen=True)
class EvaluationPlan:
    """How often, and in how many episodes per task, policies are evaluated."""

    every: Count
    episodes: Count = 10
    noise: tuple[Noise, ...] = ()  # millimetres, levels at which trained policies are evaluated too


@dataclass(frozen=True)
class Suite:
    """A suite file. `agent` has overrides for all methods, a variant has further ones."""

    environments: tuple[Environment, ...]
    methods: tuple[str, ...]
    seeds: tuple[Seed, ...]
    evaluation: EvaluationPlan
    preset: str = "paper"
    rows: HomeChoice = "auto"  # where training keeps the data's rows
    keep: Keep = "last"  # checkpoints to keep
    logger: tuple[str, ...] = ("tensorboard",)  # loggers of training
    films: bool = False  # whether evaluations are filmed
    data: Data = field(default_factory=Data)
    agent: Mapping[str, Any] = field(default_factory=dict)
    variants: Mapping[str, Mapping[str, Any]] = field(default_factory=lambda: {"": {}})

    def __post_init__(self) -> None:
        axes = {
            "environments": [environment.name for environment in self.environments],
            "methods": self.methods,
            "seeds": self.seeds,
            "variants": tuple(self.variants),
        }
        for name in filter(None, self.variants):
            names.check("a variant", name)
        for axis, values in axes.items():
            if not values:
                raise UserError(f"{axis} is empty: name at least one")
            if len(set(values)) < len(values):
                raise UserError(f"{axis} names one twice: {', '.join(map(str, values))}")

    def cells(self) -> tuple["SuiteCell", ...]:
        """Every training run of the suite, all those of one seed before the next seed's."""
        return tuple(
            SuiteCell(environment, method, variant, seed)
            for seed, environment, method, variant in itertools.product(
                self.seeds, self.environments, self.methods, self.variants
            )
        )

    def overrides(self, cell: "SuiteCell") -> dict[str, Any]:
        """The agent's fields that the suite sets in a cell; nested ones have dotted names."""
        return dict(flatten(self.agent)) | dict(flatten(self.variants[cell.variant]))


@dataclass(frozen=True)
class SuiteCell:
    """One training run of a suite."""

    environment: Environment
    method: str
    variant: str
    seed: int

    @property
    def name(self) -> str:
        """The cell's folder within that of the suite."""
        method = f"{self.method}+{self.variant}" if self.variant else self.method
        return f"{self.environment.name}/{method}/{self.seed}"


def read(path: Path) -> Suite:
    """The suite in a TOML file, or the one of that name in `READY`.

    Raises UserError if it is invalid.
    """
    if not path.suffix:
        path = READY / f"{path}.toml"
        if not path.exists():
            ready = ", ".join(sorted(file.stem for file in READY.glob("*.toml")))
            raise UserError(f"no suite is named {path.stem}: name a .toml file, or one of {ready}")
    try:
        content = tomllib.loads(files.read_text(path))
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise UserError(f"{path} is not valid TOML: {error}") from None
    return schema.read(Suite, content, str(path))


def write(path: Path, suite: Suite) -> None:
    """Write the suite to a JSON file, to be read by `read_kept`."""
    content = dataclasses.asdict(suite) | {
        "environments": _environments(suite),
        "data": suite.data.model_dump(exclude_unset=True),
    }
    files.write_sealed(path, content)


def read_kept(path: Path) -> Suite:
    """The suite written by `write`. Raises UserError if there is none or it is invalid."""
    return schema.read(Suite, files.read_sealed(path), f"{path} is invalid")


def _environments(suite: Suite) -> Sequence[Mapping[str, Any]]:
    return [
        dataclasses.asdict(environment) | {"data": environment.data and str(environment.data)}
        for environment in suite.environments
    ]
