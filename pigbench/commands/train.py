"""`pigbench train`: train one method, with one seed or several."""

import argparse
import contextlib
import dataclasses
import itertools
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, get_args, get_type_hints

import tyro

from pigbench import agents, envs, names, opengl, trackers
from pigbench.agents.config import AgentConfig, no_effect
from pigbench.agents.presets import PRESETS
from pigbench.agents.statistics import Statistics
from pigbench.data import dataset
from pigbench.data.defaults import HomeChoice
from pigbench.errors import UserError, lookup, require_left_out
from pigbench.evaluation.settings import Evaluation
from pigbench.provenance import provenance
from pigbench.runs.history import record_resumption
from pigbench.runs.run import Keep, Run, RunConfig, open_run
from pigbench.seeds import OptionalSeed, Seed
from pigbench.support import files, typed
from pigbench.support.lock import only_writer
from pigbench.training.schedule import Schedule
from pigbench.training.together import common_step


@dataclasses.dataclass(frozen=True)
class Train:
    """Train one method, with one seed or several, and evaluate it as it learns.

    METHOD comes first. The options of --agent are the method's, with the preset's defaults: to see
    them all, use `pigbench train METHOD --preset cpu --help`.

    If the command was interrupted, run it again: it continues from the last checkpoint and ends
    with the same parameters. With more --steps, a run that has ended is trained further.
    """

    method: tyro.conf.Positional[str]
    """Method; see `pigbench list methods`."""
    data: Path
    """Folder of the data set."""
    out: Path
    """Folder of the run."""
    agent: AgentConfig
    """The method's hyperparameters, by default those of the preset."""
    goals: str | None = None
    """Goals as networks see them: state, or cubes for the cubes' positions (as --agent.goals)."""
    preset: str = "paper"
    """Preset of hyperparameters: paper, or cpu for networks that two cores can train."""
    variant: str = ""
    """Name for these hyperparameters; tables and plots add it to the method's name."""
    seed: OptionalSeed = None
    """Seed of the initial parameters, batches and updates, by default 0."""
    seeds: tuple[Seed, ...] = ()
    """Several seeds instead of one; each is a run in its own folder within --out."""
    vectorized: bool = False
    """Train the seeds together, in one program on all devices, rather than one after another."""
    data_parallel: bool = False
    """Split each batch across the available devices."""
    steps: int = Schedule.steps
    """Number of updates."""
    log_every: int = Schedule.log_every
    """Number of updates between lines of metrics."""
    evaluate_every: int = Schedule.evaluate_every
    """Number of updates between evaluations, each followed by a checkpoint."""
    keep: Keep = "last"
    """Checkpoints to keep: last (the last two), best (also that of the best evaluation), or all."""
    logger: tuple[str, ...] = dataclasses.field(
        default=("tensorboard",), metadata={typed.MAY_BE_EMPTY: True}
    )
    """Loggers of metrics and success rates: tensorboard, wandb, trackio or your own."""
    films: bool = False
    """Film a success and a failure of each task at each evaluation, for films/ and the loggers."""
    evaluation: Evaluation = dataclasses.field(default_factory=Evaluation)
    """How the policy is evaluated."""
    engine: str | None = None
    """Physics engine of the evaluation, by default the one for this device."""
    rows: HomeChoice = "auto"
    """Where the data's rows are kept: device, disk, or auto for the device if they fit."""

    def __post_init__(self) -> None:
        lookup("preset", PRESETS, self.preset)
        if self.variant:
            names.check("the variant", self.variant)
        if len(set(self.seeds)) < len(self.seeds):
            raise UserError(f"seeds names one twice: {', '.join(map(str, self.seeds))}")
        if self.seeds:
            require_left_out(self, "beside seeds", "seed")
        if len(self.seeds) < 2:
            require_left_out(self, "without several seeds", "vectorized")
        if self.goals not in (None, self.agent.goals):
            raise UserError(
                f"goals is {self.goals!r}, but agent.goals is {self.agent.goals!r}: leave one out"
            )
        for name in self.logger:
            trackers.get(name)
        self._schedule()  # so that a suite rejects a bad schedule before it begins

    @classmethod
    def defaults(cls, arguments: Sequence[str]) -> "Train":
        """The defaults of the chosen method and preset, which determine the available fields.

        Without a method, they are those that all methods have. Raises UserError if it does not come
        first, for then it is not known which of the arguments it is.
        """
        preset = _given(arguments, "--preset", cls.preset)
        agent = AgentConfig()
        if arguments and not arguments[0].startswith("-"):
            agent = _of_kinds(agents.get(arguments[0]).preset(preset), arguments, "--agent")
            _refuse_decided(agent, arguments)
        elif arguments and not {"-h", "--help"}.intersection(arguments):
            raise UserError("METHOD must come first: pigbench train METHOD --data PATH --out PATH")
        goals = _given(arguments, "--goals", agent.goals)
        return cls(
            method=tyro.MISSING,
            data=tyro.MISSING,
            out=tyro.MISSING,
            agent=dataclasses.replace(agent, goals=goals),
            preset=preset,
        )

    def run(self) -> None:
        """Train to the end, continuing an earlier run that was interrupted."""
        from pigbench.data import homes
        from pigbench.training.sharding import Sharding
        from pigbench.training.train import train

        if self.films:
            opengl.choose()
        groups = self._groups()
        for folder in itertools.chain.from_iterable(groups):
            files.require_folder(folder)
        data = dataset.load(self.data)
        env = envs.make(data.spec.environment, engine=self._engine, profile=data.spec.physics)
        dataset.check_layout(data, env.layout)
        split = data.split("train")
        home = homes.choose(self.rows, split)
        rows = homes.open_rows(split, home)
        statistics = Statistics.of(rows.observations)
        agent = agents.build(self.method, self.agent, env.space, statistics=statistics)
        digest = data.digest
        origin = provenance(dataset=self.data, dataset_digest=digest)
        config = partial(
            self.config,
            environment=data.spec.environment,
            physics=data.spec.physics,
            dataset_digest=digest,
        )
        sharding = Sharding.over_all(
            seeds=len(groups[0]),
            batch_size=self.agent.batch_size,
            data_parallel=self.data_parallel,
        )
        for group in groups:
            with contextlib.ExitStack() as stack:
                for folder in group:
                    stack.enter_context(only_writer(folder))
                runs = [
                    open_run(folder, config(seed), origin, statistics)
                    for folder, seed in group.items()
                ]
                _note_resumed(runs, origin)
                train(
                    runs,
                    agent,
                    rows,
                    env,
                    schedule=self._schedule(),
                    evaluation=self.evaluation,
                    keep=self.keep,
                    shown_by=[trackers.get(name) for name in self.logger],
                    films=self.films,
                    sharding=sharding,
                    remark=", ".join(filter(None, (str(home), str(sharding)))),
                )
            for folder in group:
                print(typed.complete(folder, seen_by="table"))

    @property
    def _engine(self) -> str:
        return self.engine or envs.default_engine()

    def _schedule(self) -> Schedule:
        return Schedule(self.steps, self.log_every, self.evaluate_every)

    def _groups(self) -> list[dict[Path, int]]:
        """Folders and seeds of the runs, grouped by what is trained together."""
        runs = {self.out / str(seed): seed for seed in self.seeds} or {self.out: self.seed or 0}
        return [runs] if self.vectorized else [{folder: seed} for folder, seed in runs.items()]

    def config(
        self, seed: int, *, environment: str, physics: str, dataset_digest: str
    ) -> RunConfig:
        """The configuration that identifies the run of a seed on a data set."""
        return RunConfig(
            method=self.method,
            preset=self.preset,
            agent=self.agent.record(),
            environment=environment,
            physics=physics,
            dataset_digest=dataset_digest,
            steps=self.steps,
            seed=seed,
            evaluation=dataclasses.asdict(self.evaluation)
            | {"every": self.evaluate_every, "engine": self._engine},
            variant=self.variant,
        )


def _of_kinds(config: Any, arguments: Sequence[str], prefix: str) -> Any:
    """`config` with the kinds that `arguments` name, such as --agent.regularizer.kind eikonal."""
    changes: dict[str, Any] = {}
    for field in dataclasses.fields(config):
        value, option = getattr(config, field.name), f"{prefix}.{field.name.replace('_', '-')}"
        if known := _kinds(config, field.name):
            kind = _given(arguments, f"{option}.kind", value.kind)
            changes[field.name] = value if kind == value.kind else lookup(field.name, known, kind)()
        elif dataclasses.is_dataclass(value):
            changes[field.name] = _of_kinds(value, arguments, option)
    return dataclasses.replace(config, **changes)


def _refuse_decided(config: AgentConfig, arguments: Sequence[str]) -> None:
    """Raise UserError if an option is given whose value other hyperparameters decide."""
    given = [argument.partition("=")[0].replace("_", "-") for argument in arguments]
    for place in config.decided:
        option = f"--agent.{place.replace('_', '-')}"
        if any(name == option or name.startswith(f"{option}.") for name in given):
            raise no_effect(place)


def _kinds(config: Any, field: str) -> dict[str, Any]:
    """The dataclasses that a field may hold, by the `kind` of each; empty if they have none."""
    declared = get_args(get_type_hints(type(config))[field])
    return {one.kind: one for one in declared if hasattr(one, "kind")}


def _given(arguments: Sequence[str], option: str, default: str) -> str:
    """The value of an option on which the available fields depend."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument(option, dest="value", nargs="?", default=default)
    return parser.parse_known_args(arguments)[0].value or default


def _note_resumed(runs: Sequence[Run], origin: Mapping[str, Any]) -> None:
    """Record and print what runs are resumed with, if it differs from before."""
    step = common_step(runs) or 0
    for run in (one for one in runs if not one.is_trained):
        change = record_resumption(run.provenance_path, origin, step=step)
        if change is not None:
            print(f"{run.path} is resumed at step {step:,}, but {change}; provenance.json has both")
