"""What a suite file says: environments, methods, variants, seeds; their product are its cells."""

import dataclasses
import itertools
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pydantic

from pigbench import names
from pigbench.data.defaults import HomeChoice
from pigbench.errors import UserError
from pigbench.seeds import Seed
from pigbench.support import files
from pigbench.support.compare import flatten
from pigbench.training.run import Keep

KEPT = "suite.json"
"""What `write` is to keep a suite in, in its folder."""

READY = Path(__file__).parent / "ready"
"""The folder of suites that come with the package."""

_UNKNOWN_FIELD = "unexpected_keyword_argument"


@dataclass(frozen=True)
class Environment:
    """An environment, the size of its training data, and how long methods train on it."""

    name: str
    transitions: int
    steps: int
    data: Path | None = None  # folder of the data set; by default in the suite's own

    __pydantic_config__ = pydantic.ConfigDict(extra="forbid")


@dataclass(frozen=True)
class Data:
    """How data that is not there is generated."""

    policy: str = "play"
    physics: str = "exact"
    seed: Seed = 0
    validation_episodes: int | None = None
    episode_transitions: int = 1000  # of an episode, by which the number of episodes is reckoned
    filter: bool = False  # whether only good episodes are kept, as `pigbench data filter` has it

    __pydantic_config__ = pydantic.ConfigDict(extra="forbid")


@dataclass(frozen=True)
class Evaluation:
    """How often, and in how many episodes of each task, policies are evaluated."""

    every: int
    episodes: int = 10
    noise: tuple[float, ...] = ()  # millimetres, in which trained policies are evaluated too

    __pydantic_config__ = pydantic.ConfigDict(extra="forbid")


@dataclass(frozen=True)
class Suite:
    """A suite file. `agent` holds overrides for every method, a variant further ones."""

    environments: tuple[Environment, ...]
    methods: tuple[str, ...]
    seeds: tuple[Seed, ...]
    evaluation: Evaluation
    preset: str = "paper"
    rows: HomeChoice = "auto"  # where trainings keep the data's rows
    keep: Keep = "last"  # checkpoints of trainings that stay
    logger: tuple[str, ...] = ("tensorboard",)  # where trainings are shown
    films: bool = False  # whether evaluations are filmed
    data: Data = field(default_factory=Data)
    agent: Mapping[str, Any] = field(default_factory=dict)
    variants: Mapping[str, Mapping[str, Any]] = field(default_factory=lambda: {"": {}})

    __pydantic_config__ = pydantic.ConfigDict(extra="forbid")

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

    def cells(self) -> tuple["Cell", ...]:
        """Every training of the suite, a seed's whole product before the next seed's."""
        return tuple(
            Cell(environment, method, variant, seed)
            for seed, environment, method, variant in itertools.product(
                self.seeds, self.environments, self.methods, self.variants
            )
        )

    def overrides(self, cell: "Cell") -> dict[str, Any]:
        """The fields of the agent that the suite sets in a cell, nested ones dotted."""
        return dict(flatten(self.agent)) | dict(flatten(self.variants[cell.variant]))


@dataclass(frozen=True)
class Cell:
    """One training of a suite."""

    environment: Environment
    method: str
    variant: str
    seed: int

    @property
    def name(self) -> str:
        """The cell's folder within the suite's."""
        method = f"{self.method}+{self.variant}" if self.variant else self.method
        return f"{self.environment.name}/{method}/{self.seed}"


def read(path: Path) -> Suite:
    """The suite in a TOML file, or of a name in `READY`.

    Raises UserError for what is wrong with it.
    """
    if not path.suffix:
        path = READY / f"{path}.toml"
        if not path.exists():
            ready = ", ".join(sorted(file.stem for file in READY.glob("*.toml")))
            raise UserError(f"no suite is named {path.stem}: name a .toml file, or one of {ready}")
    try:
        return pydantic.TypeAdapter(Suite).validate_python(tomllib.loads(files.read_text(path)))
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise UserError(f"{path} is not valid TOML: {error}") from None
    except UserError as error:
        raise UserError(f"{path}: {error}") from None
    except pydantic.ValidationError as error:
        first = min(error.errors(), key=lambda one: one["type"] != _UNKNOWN_FIELD)
        where = ".".join(map(str, first["loc"]))
        raise UserError(f"{path}: {where}: {_explain(first)}") from None


def write(path: Path, suite: Suite) -> None:
    """Keeps the suite in a JSON file, which `read_kept` reads."""
    content = dataclasses.asdict(suite) | {"environments": _environments(suite)}
    files.write_json(path, files.sealed(content))


def read_kept(path: Path) -> Suite:
    """The suite that `write` kept. Raises UserError when there is none or it is torn."""
    try:
        return pydantic.TypeAdapter(Suite).validate_python(files.read_json(path))
    except pydantic.ValidationError as error:
        raise UserError(f"{path} is torn: {error.errors()[0]['msg']}") from None


def _environments(suite: Suite) -> Sequence[Mapping[str, Any]]:
    return [
        dataclasses.asdict(environment) | {"data": environment.data and str(environment.data)}
        for environment in suite.environments
    ]


def _explain(error: Any) -> str:
    if error["type"] == _UNKNOWN_FIELD:
        return "there is no such field"
    if error["type"] == "missing":
        return "this field is missing"
    return f"{error['msg']}, not {error['input']!r}"
