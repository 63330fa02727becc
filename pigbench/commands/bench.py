"""`pigbench bench`: running times, side by side."""

import dataclasses
from pathlib import Path

import tyro

from pigbench import agents, envs, provenance
from pigbench.bench import startup
from pigbench.bench.turns import Turns, save, take_turns
from pigbench.data import dataset
from pigbench.errors import require
from pigbench.report.formats import markdown_grid
from pigbench.support import files, memory


@dataclasses.dataclass(frozen=True)
class BenchTrain:
    """Time the updates of methods, and compare them with those of the first.

    On two cores or more, set NPROC to the number of threads you mean to train with.
    """

    methods: tyro.conf.Positional[tuple[str, ...]] = ()
    """Methods, compared with the first; by default all methods."""
    environment: str = "cube-single"
    """Environment for whose observations and actions the networks are built."""
    preset: str = "cpu"
    """Preset of hyperparameters: cpu or paper."""
    turns: Turns = dataclasses.field(default_factory=Turns)
    """How the contenders take turns."""
    json: Path | None = None
    """File for the result as JSON, with the machine and versions."""

    def run(self) -> None:
        """Measure and print a table."""
        from pigbench.bench import training

        files.require_files(self.json)
        contenders = training.contenders(
            self.environment, self.methods or agents.names(), self.preset
        )
        timings = take_turns("bench train", contenders, self.turns)
        print(markdown_grid(training.table(timings)))
        save(self.json, self, timings)


@dataclasses.dataclass(frozen=True)
class BenchGenerate:
    """Time data generation, OGBench's generator (which must be installed), and the engine alone.

    The engine alone starts from the same states with the same controls, but without policy and
    observations.
    """

    environment: str = "cube-double"
    """Environment."""
    simulations: int = 50
    """Simulations in a batch; pigbench simulates as many batches at once as for a data set."""
    physics: tuple[str, ...] = ("exact", "fast")
    """Physics profiles."""
    engine: str | None = None
    """Physics engine, by default the one for this device."""
    turns: Turns = dataclasses.field(default_factory=Turns)
    """How the contenders take turns."""
    json: Path | None = None
    """File for the result as JSON, with the machine and versions."""

    def run(self) -> None:
        """Measure and print a table."""
        from pigbench.bench import comparison

        files.require_files(self.json)
        require(self, lambda x: x >= 1, "at least 1", "simulations")
        memory.require_for(self.simulations)
        engine = self.engine or envs.default_engine()
        contenders = comparison.generation(
            self.environment, self.simulations, engine=engine, profiles=self.physics
        )
        timings = take_turns("bench generate", contenders, self.turns)
        print(markdown_grid(comparison.table(timings)))
        for profile in self.physics:
            share = comparison.share_of_engine(timings, profile)
            print(f"{profile}: {share:.2f} of the engine's rate alone")
        save(self.json, dataclasses.replace(self, engine=engine), timings)


@dataclasses.dataclass(frozen=True)
class BenchEvaluate:
    """Time the evaluation of an untrained policy here and in OGBench, one environment at a time."""

    environment: str = "cube-double"
    """Environment."""
    method: str = "gcivl"
    """Method whose policy acts."""
    preset: str = "cpu"
    """Preset of hyperparameters: cpu or paper."""
    episodes: int = 10
    """Episodes per task, all at once."""
    physics: tuple[str, ...] = ("exact", "fast")
    """Physics profiles."""
    engine: str | None = None
    """Physics engine, by default the one for this device."""
    turns: Turns = dataclasses.field(default_factory=Turns)
    """How the contenders take turns; a turn is at least one evaluation."""
    json: Path | None = None
    """File for the result as JSON, with the machine and versions."""

    def run(self) -> None:
        """Measure and print a table."""
        from pigbench.bench import comparison

        files.require_files(self.json)
        engine = self.engine or envs.default_engine()
        contenders = comparison.evaluation(
            self.environment,
            self.episodes,
            method=self.method,
            preset=self.preset,
            engine=engine,
            profiles=self.physics,
        )
        timings = take_turns("bench evaluate", contenders, self.turns)
        print(markdown_grid(comparison.table(timings)))
        save(self.json, dataclasses.replace(self, engine=engine), timings)


@dataclasses.dataclass(frozen=True)
class BenchRows:
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
        from pigbench.bench import rows, throwaway
        from pigbench.data import homes

        require(self, lambda x: x >= 1, "at least 1", "transitions")
        files.require_files(self.json)
        with throwaway.dataset(self.environment, self.transitions, self.folder) as data:
            split = dataset.load(data).split("train")
            home, possible = rows.possible(split)
            print(
                f"{split.rows:,} rows, {homes.size(split) / 1e9:.1f} GB, a few simulated episodes "
                f"repeated; auto chooses {home}"
            )
            measured = rows.measure(data, possible, self.turns)
        print(markdown_grid(rows.table(measured)))
        save(self.json, self, measured.timings, opened=measured.opened, resident=measured.resident)


@dataclasses.dataclass(frozen=True)
class Startup:
    """Measure the processor seconds that commands take to start, each in its own process.

    Commands that work do little of it, first with nothing compiled, then with what JAX has kept.
    """

    turns: int = 3
    """Turns per command; medians are over turns."""
    json: Path | None = None
    """File for the result as JSON, with the machine and versions."""

    def run(self) -> None:
        """Measure and print two tables."""
        require(self, lambda x: x >= 1, "at least 1", "turns")
        files.require_files(self.json)
        looks = startup.measure(self.turns)
        print(markdown_grid(startup.table({"processor seconds": looks})), flush=True)
        work = startup.measure_work(self.turns)
        print()
        print(markdown_grid(startup.table(work)))
        provenance.save(self.json, seconds=looks, work=work)
