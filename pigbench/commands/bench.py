"""`pigbench bench`: how long things take, side by side."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import jax
import tyro

from pigbench import agents, envs
from pigbench.bench import peers, simulation, training
from pigbench.bench.timing import Contender, Timing, alternate
from pigbench.errors import UserError
from pigbench.fidelity import peer
from pigbench.report.formats import markdown_grid
from pigbench.support import files
from pigbench.support.progress import Progress
from pigbench.training.provenance import surroundings


@dataclasses.dataclass(frozen=True)
class Turns:
    """How the contenders take turns; medians are over turns."""

    turns: int = 5
    """Turns of each contender."""
    seconds: float = 2.0
    """Length of a turn, in seconds."""

    def __post_init__(self) -> None:
        if self.turns < 1:
            raise UserError(f"turns is {self.turns}: it must be at least 1")


@dataclasses.dataclass(frozen=True)
class Train:
    """Time the updates of methods, and compare them with the first one's.

    On two cores or more, set NPROC to the number of threads you mean to train with.
    """

    methods: tyro.conf.Positional[tuple[str, ...]] = ()
    """Methods, the first of which the others are compared with; by default all."""
    environment: str = "cube-single"
    """Environment whose observations and actions the networks take."""
    preset: str = "cpu"
    """Preset of hyper-parameters: cpu or paper."""
    turns: Turns = dataclasses.field(default_factory=Turns)
    """How the contenders take turns."""
    json: Path | None = None
    """File for the result as JSON, with machine and versions."""

    def run(self) -> None:
        """Measure and print a table."""
        contenders = training.contenders(
            self.environment, self.methods or agents.names(), self.preset
        )
        timings = measure("bench train", contenders, self.turns)
        reference = next(iter(timings))
        print(
            markdown_grid(
                [
                    ("method", "ms an update", f"times {reference}", "s to compile"),
                    *(
                        (
                            name,
                            f"{1e3 * timing.median:.1f}",
                            f"{timing.ratio(timings[reference]):.2f}",
                            f"{timing.first - timing.median:.1f}",
                        )
                        for name, timing in timings.items()
                    ),
                ]
            )
        )
        save(self.json, self, timings)


@dataclasses.dataclass(frozen=True)
class Generate:
    """Time data generation beside OGBench's generator, which must be installed."""

    environment: str = "cube-double"
    """Environment."""
    simulations: int = 100
    """Simulations at once."""
    physics: tuple[str, ...] = ("exact", "fast")
    """Physics profiles."""
    engine: str = dataclasses.field(default_factory=envs.default_engine)
    """Physics engine."""
    turns: Turns = dataclasses.field(default_factory=Turns)
    """How the contenders take turns."""
    json: Path | None = None
    """File for the result as JSON, with machine and versions."""

    def run(self) -> None:
        """Measure and print a table."""
        ours = [
            simulation.generation(
                envs.make(self.environment, engine=self.engine, profile=profile),
                self.simulations,
                name=f"pigbench {profile}",
            )
            for profile in self.physics
        ]
        theirs = peers.generation(self.environment)
        timings = measure("bench generate", [theirs, *ours], self.turns)
        _print_rates(timings)
        save(self.json, self, timings)


@dataclasses.dataclass(frozen=True)
class Evaluate:
    """Time the evaluation of a fresh policy beside OGBench's environments, one at a time."""

    environment: str = "cube-double"
    """Environment."""
    method: str = "gcivl"
    """Method whose policy acts."""
    preset: str = "cpu"
    """Preset of hyper-parameters: cpu or paper."""
    episodes: int = 10
    """Episodes of each task, all at once."""
    physics: tuple[str, ...] = ("exact", "fast")
    """Physics profiles."""
    engine: str = dataclasses.field(default_factory=envs.default_engine)
    """Physics engine."""
    turns: Turns = dataclasses.field(default_factory=Turns)
    """How the contenders take turns; a turn is one evaluation at least."""
    json: Path | None = None
    """File for the result as JSON, with machine and versions."""

    def run(self) -> None:
        """Measure and print a table."""
        environments = {
            profile: envs.make(self.environment, engine=self.engine, profile=profile)
            for profile in self.physics
        }
        ours = [
            simulation.evaluation(
                env, self.episodes, self.method, self.preset, name=f"pigbench {profile}"
            )
            for profile, env in environments.items()
        ]
        theirs = peers.evaluation(envs.make(self.environment), self.method, self.preset)
        timings = measure("bench evaluate", [theirs, *ours], self.turns)
        _print_rates(timings)
        save(self.json, self, timings)


def _print_rates(timings: Mapping[str, Timing]) -> None:
    """Control steps a second, and how many times the peer's."""
    lines = [
        (
            name,
            f"{1 / timing.median:,.0f}",
            f"{timings[peer.NAME].ratio(timing):.1f}",
            f"{timing.first:.1f}",
        )
        for name, timing in timings.items()
    ]
    header = ("", "control steps a second", f"times {peer.NAME}", "s of the first call")
    print(markdown_grid([header, *lines]))


def measure(task: str, contenders: list[Contender], turns: Turns) -> Mapping[str, Timing]:
    """Times of all contenders by name, under a progress line; compilation is not cached."""
    jax.config.update("jax_enable_compilation_cache", False)  # compilation is timed too
    total = (turns.turns + 1) * len(contenders)
    with Progress(task, total=total, unit="turns") as progress:
        return alternate(
            contenders,
            turns=turns.turns,
            seconds=turns.seconds,
            report=lambda name: progress.advance(1, name),
        )


def save(path: Path | None, command: object, timings: Mapping[str, Timing]) -> None:
    """Keeps the settings of a command, and all seconds, with machine and versions."""
    if path is None:
        return
    settings = {name: value for name, value in vars(command).items() if not isinstance(value, Path)}
    settings["turns"] = dataclasses.asdict(settings["turns"])
    content = {
        "settings": settings,
        "seconds": {name: dataclasses.asdict(timing) for name, timing in timings.items()},
    }
    files.write_json(path, content | surroundings())
