"""`pigbench bench`: running times, side by side."""

import contextlib
import dataclasses
import statistics
from collections.abc import Mapping
from pathlib import Path

import jax
import tyro

from pigbench import agents, envs
from pigbench.bench import peers, rows, simulation, startup, training
from pigbench.bench.timing import Contender, Timing, alternate
from pigbench.data import dataset, homes
from pigbench.errors import UserError
from pigbench.fidelity import peer
from pigbench.report.formats import markdown_grid
from pigbench.support import files, memory
from pigbench.support.progress import Progress
from pigbench.training.provenance import surroundings


@dataclasses.dataclass(frozen=True)
class Turns:
    """How contenders take turns; medians are over turns."""

    turns: int = 5
    """Turns per contender."""
    seconds: float = 2.0
    """Length of a turn in seconds."""

    def __post_init__(self) -> None:
        if self.turns < 1:
            raise UserError(f"turns is {self.turns}: it must be at least 1")


@dataclasses.dataclass(frozen=True)
class Train:
    """Time the updates of methods, and compare them with those of the first.

    On two cores or more, set NPROC to the number of threads you mean to train with.
    """

    methods: tyro.conf.Positional[tuple[str, ...]] = ()
    """Methods, compared with the first; by default all methods."""
    environment: str = "cube-single"
    """Environment for whose observations and actions the networks are built."""
    preset: str = "cpu"
    """Preset of hyper-parameters: cpu or paper."""
    turns: Turns = dataclasses.field(default_factory=Turns)
    """How the contenders take turns."""
    json: Path | None = None
    """File for the result as JSON, with the machine and versions."""

    def run(self) -> None:
        """Measure and print a table."""
        files.require_files(self.json)
        contenders = training.contenders(
            self.environment, self.methods or agents.names(), self.preset
        )
        timings = measure("bench train", contenders, self.turns)
        reference = next(iter(timings))
        print(
            markdown_grid(
                [
                    ("method", "ms per update", f"times {reference}", "s to compile"),
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
    """Time data generation, OGBench's generator (which must be installed), and the engine alone.

    The engine alone starts from the same states with the same controls, but without policy and
    observations.
    """

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
    """File for the result as JSON, with the machine and versions."""

    def run(self) -> None:
        """Measure and print a table."""
        files.require_files(self.json)
        if self.simulations < 1:
            raise UserError(f"simulations is {self.simulations}: it must be at least 1")
        memory.require(self.simulations)
        contenders = [peers.generation(self.environment)]
        for profile in self.physics:
            env = envs.make(self.environment, engine=self.engine, profile=profile)
            name = f"pigbench {profile}"
            contenders += [
                simulation.generation(env, self.simulations, name=name),
                simulation.engine(env, self.simulations, name=f"{name}, engine alone"),
            ]
        timings = measure("bench generate", contenders, self.turns)
        _print_rates(timings)
        for profile in self.physics:
            ours = timings[f"pigbench {profile}"]
            engine = timings[f"pigbench {profile}, engine alone"]
            print(f"{profile}: {engine.ratio(ours):.2f} of the engine's rate alone")
        save(self.json, self, timings)


@dataclasses.dataclass(frozen=True)
class Evaluate:
    """Time the evaluation of an untrained policy here and in OGBench, one environment at a time."""

    environment: str = "cube-double"
    """Environment."""
    method: str = "gcivl"
    """Method whose policy acts."""
    preset: str = "cpu"
    """Preset of hyper-parameters: cpu or paper."""
    episodes: int = 10
    """Episodes per task, all at once."""
    physics: tuple[str, ...] = ("exact", "fast")
    """Physics profiles."""
    engine: str = dataclasses.field(default_factory=envs.default_engine)
    """Physics engine."""
    turns: Turns = dataclasses.field(default_factory=Turns)
    """How the contenders take turns; a turn is at least one evaluation."""
    json: Path | None = None
    """File for the result as JSON, with the machine and versions."""

    def run(self) -> None:
        """Measure and print a table."""
        files.require_files(self.json)
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


@dataclasses.dataclass(frozen=True)
class Rows:
    """Time GCIVL's updates (preset cpu) with rows on the device and on disk, and opening the data.

    The data set is deleted afterwards. Its episodes are a few simulated ones, repeated.
    """

    transitions: int = 10_000_000
    """Transitions of the data set."""
    environment: str = "cube-single"
    """Environment that the rows are from."""
    folder: Path | None = None
    """Folder in which the data set is made; by default the system's folder of temporary files."""
    turns: Turns = dataclasses.field(default_factory=Turns)
    """How the device and the disk take turns."""
    json: Path | None = None
    """File for the result as JSON, with the machine and versions."""

    def run(self) -> None:
        """Measure and print a table."""
        if self.transitions < 1:
            raise UserError(f"transitions is {self.transitions}: it must be at least 1")
        files.require_files(self.json)
        with rows.throw_away(self.environment, self.transitions, self.folder) as data:
            split = dataset.load(data).split("train")
            home = homes.choose("auto", split)
            names = ["device", "disk"] if home.name == "device" else ["disk"]
            print(
                f"{split.rows:,} rows, {homes.size(split) / 1e9:.1f} GB, a few simulated episodes "
                f"repeated; auto chooses {home}"
            )
            with contextlib.ExitStack() as stack:
                trainers = {
                    name: stack.enter_context(contextlib.closing(rows.Trainer(data, name)))
                    for name in names
                }
                contenders = [trainer.contender() for trainer in trainers.values()]
                timings = measure("bench rows", contenders, self.turns)
                resident = {name: trainer.resident() for name, trainer in trainers.items()}
        lines = [
            (
                name,
                f"{trainers[name].seconds_to_open:.2f}",
                f"{1 / timing.median:.1f}",
                f"{timings[names[0]].ratio(timing):.2f}",
                f"{resident[name] / 1e9:.2f}",
            )
            for name, timing in timings.items()
        ]
        header = ("rows on", "s to open", "updates per second", f"times {names[0]}", "GB resident")
        print(markdown_grid([header, *lines]))
        opened = {name: trainer.seconds_to_open for name, trainer in trainers.items()}
        save(self.json, self, timings, opened=opened, resident=resident)


_STARTED = (
    "--help",
    "list envs",
    "list methods",
    "data info --help",
    "table --help",
    "plot --help",
    "suite status --help",
    "generate --help",
    "train --help",
)


@dataclasses.dataclass(frozen=True)
class Startup:
    """Measure the processor seconds that commands take to start, each in its own process."""

    turns: int = 5
    """Turns per command; medians are over turns."""
    json: Path | None = None
    """File for the result as JSON, with the machine and versions."""

    def run(self) -> None:
        """Measure and print a table."""
        if self.turns < 1:
            raise UserError(f"turns is {self.turns}: it must be at least 1")
        files.require_files(self.json)
        taken: dict[str, list[float]] = {command: [] for command in _STARTED}
        with Progress("bench startup", total=self.turns * len(taken), unit="starts") as progress:
            for _ in range(self.turns):
                for command, times in taken.items():
                    times.append(startup.seconds(command.split()))
                    progress.advance(1, command)
        lines = [(name, f"{statistics.median(times):.2f}") for name, times in taken.items()]
        print(markdown_grid([("pigbench", "processor seconds"), *lines]))
        if self.json is not None:
            files.write_json(self.json, {"seconds": taken} | surroundings())


def _print_rates(timings: Mapping[str, Timing]) -> None:
    """Print control steps per second, and their ratio to the peer's."""
    lines = [
        (
            name,
            f"{1 / timing.median:,.0f}",
            f"{timings[peer.NAME].ratio(timing):.1f}",
            f"{timing.first:.1f}",
        )
        for name, timing in timings.items()
    ]
    header = ("", "control steps per second", f"times {peer.NAME}", "s of the first call")
    print(markdown_grid([header, *lines]))


def measure(task: str, contenders: list[Contender], turns: Turns) -> Mapping[str, Timing]:
    """Time all contenders, by name, showing progress; compilation is not cached."""
    jax.config.update("jax_enable_compilation_cache", False)  # compilation is timed too
    total = (turns.turns + 1) * len(contenders)
    with Progress(task, total=total, unit="turns") as progress:
        return alternate(
            contenders,
            turns=turns.turns,
            seconds=turns.seconds,
            report=lambda name: progress.advance(1, name),
        )


def save(path: Path | None, command: object, timings: Mapping[str, Timing], **more: object) -> None:
    """Save a command's settings, all seconds and `more`, with machine and versions."""
    if path is None:
        return
    settings = {name: value for name, value in vars(command).items() if not isinstance(value, Path)}
    settings["turns"] = dataclasses.asdict(settings["turns"])
    content = {
        "settings": settings,
        "seconds": {name: dataclasses.asdict(timing) for name, timing in timings.items()},
    }
    files.write_json(path, content | more | surroundings())
