"""`pigbench parity`: how close our simulations and the data made in them are to OGBench's."""

import dataclasses
import itertools
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import tyro

from pigbench import envs, seeds
from pigbench.errors import UserError
from pigbench.fidelity import closed_loop, distributions, peer, recording, replay
from pigbench.fidelity.closed_loop import Successes
from pigbench.fidelity.recording import Recording
from pigbench.fidelity.replay import Errors, Outcomes, Windows
from pigbench.report.formats import markdown_grid
from pigbench.seeds import Seed
from pigbench.support import files
from pigbench.support.progress import Progress
from pigbench.training.evaluate import Evaluation
from pigbench.training.provenance import surroundings
from pigbench.training.restore import restore

Table = Sequence[tuple[str, ...]]  # header first

_EPISODE_LENGTH = 1000  # control steps
_HORIZONS = (1, 10, replay.WINDOW)  # control steps after which errors are compared
_PERCENTILE = 95
_CLOSE, _NEAR = 1e-4, 2e-3  # metres

# Column -> the error's field, and the factor that converts it to the column's unit.
_COLUMNS = {
    "pinch (mm)": ("pinch", 1e3),
    "opening": ("opening", 1),
    "contact": ("contact", 1),
    "cube (mm)": ("cube", 1e3),
    "turn (deg)": ("turn", np.degrees(1)),
}


@dataclasses.dataclass(frozen=True)
class Parity:
    """Replay episodes of the ogbench package, which must be installed, from the same states.

    OGBench's scripted policy acts in OGBench's physics; the same actions are applied here, over
    windows of 50 control steps and over whole sub-tasks.
    """

    environment: tyro.conf.Positional[str] = "cube-double"
    """Environment."""
    policy: str = "play"
    """OGBench's scripted policy: play or noisy."""
    episodes: int = 20
    """Episodes of 1,000 control steps."""
    seed: Seed = 0
    """Seed of the episodes."""
    engine: tuple[str, ...] = dataclasses.field(default_factory=lambda: (envs.default_engine(),))
    """Physics engines."""
    physics: tuple[str, ...] = ("exact", "fast")
    """Physics profiles."""
    json: Path | None = None
    """File for the result as JSON, with the machine and versions."""

    def run(self) -> None:
        """Measure, and print a table of errors and one of outcomes."""
        files.require_files(self.json)
        ours = {
            (engine, profile): envs.make(self.environment, engine=engine, profile=profile)
            for engine, profile in itertools.product(self.engine, self.physics)
        }
        recordings = _record(self.environment, self.policy, self.episodes, self.seed)
        errors, ends = [], []
        with Progress("replaying", total=len(ours), unit="simulators") as progress:
            for name, env in ours.items():
                errors += _error_lines(name, replay.windows(env, recordings))
                ends.append((*name, *_outcome_line(replay.outcomes(env, recordings))))
                progress.advance(1, ", ".join(name))
        kinds = ("engine", "physics", "situation", "steps", "windows")
        shares = (f"cube within {1e3 * _CLOSE:g} mm", f"{1e3 * _NEAR:g} mm")
        error_table = [(*kinds, *_COLUMNS, *shares), *errors]
        end_table = [("engine", "physics", "sub-tasks", "same grasp", "same placement"), *ends]
        print(markdown_grid(error_table))
        print(f"\nErrors: {_PERCENTILE}th percentiles over windows, for the farthest cube.\n")
        print(markdown_grid(end_table))
        _save(self.json, self, {"errors": error_table, "outcomes": end_table})


@dataclasses.dataclass(frozen=True)
class ParityData:
    """Compare data from a scripted policy with OGBench's from the same policy, by quantity.

    Both are generated anew, OGBench's by the ogbench package, which must be installed.
    """

    environment: tyro.conf.Positional[str] = "cube-double"
    """Environment."""
    policies: tuple[str, ...] = ("play", "noisy")
    """Scripted policies."""
    episodes: int = 20
    """Episodes of 1,000 control steps per policy."""
    seed: Seed = 0
    """Seed of the episodes."""
    engine: str = dataclasses.field(default_factory=envs.default_engine)
    """Physics engine."""
    physics: str = "exact"
    """Physics profile."""
    json: Path | None = None
    """File for the result as JSON, with the machine and versions."""

    def run(self) -> None:
        """Measure and print a table."""
        files.require_files(self.json)
        env = envs.make(self.environment, engine=self.engine, profile=self.physics)
        lines = []
        for policy in self.policies:
            recordings = _record(self.environment, policy, self.episodes, self.seed)
            theirs = [distributions.of_recording(env.scene, one) for one in recordings]
            ours = distributions.simulate(
                env, policy, episodes=self.episodes, steps=_EPISODE_LENGTH, seed=self.seed
            )
            lines += [
                (name, policy, f"{one:.3g}", f"{other:.3g}", f"{statistic:.2f}", f"{p:.2g}")
                for name, (one, other, statistic, p) in distributions.compare(theirs, ours).items()
            ]
        table = [("quantity", "policy", peer.NAME, "pigbench", "KS statistic", "p"), *lines]
        print(markdown_grid(table))
        print(f"\nMeans over {self.episodes} episodes each; the test compares the episodes' means.")
        _save(self.json, self, {"quantities": table})


@dataclasses.dataclass(frozen=True)
class ParityPolicy:
    """Let a run's policy act here and in the ogbench package, which must be installed.

    Both episodes of a pair have the same start, the same goal and the same random draws.
    """

    run_folder: tyro.conf.Positional[Path]
    """Folder of the run."""
    episodes: int = 60
    """Pairs of episodes per task."""
    seed: Seed = Evaluation.seed
    """Seed of the scenes and of the policy's random draws."""
    engine: str | None = None
    """Physics engine, by default that of the run's own evaluations."""
    json: Path | None = None
    """File for the result as JSON, with the machine and versions."""

    def run(self) -> None:
        """Simulate and print a table."""
        files.require_files(self.json)
        evaluation = Evaluation(self.episodes, self.seed)
        run, env, agent, state = restore(self.run_folder, engine=self.engine)
        total = env.num_tasks * self.episodes
        with Progress(f"acting in {peer.NAME}", total=total, unit="episodes") as progress:
            successes = closed_loop.simulate(env, agent, state.acting, evaluation, progress.reach)
        names = [task.name for task in env.spec.tasks]
        lines = [
            _pair_line(name, Successes(*pair))
            for name, *pair in zip(names, *successes, strict=True)
        ]
        ends = ("both succeed", "only pigbench", f"only {peer.NAME}", "neither")
        header = ("task", *ends, "pigbench", peer.NAME, "McNemar's p")
        table = [header, *lines, _pair_line("all tasks", successes)]
        print(markdown_grid(table))
        print(
            f"\nPairs of episodes, and success in each simulator: {run.config.label}, "
            f"{int(state.step):,} updates, {run.config.environment}; physics: "
            f"{run.config.physics}, engine {env.backend}. The test is exact."
        )
        _save(self.json, dataclasses.replace(self, engine=env.backend), {"pairs": table})


def _record(environment: str, policy: str, episodes: int, seed: int) -> list[Recording]:
    if episodes < 1:
        raise UserError(f"episodes is {episodes}: it must be at least 1")
    seeds.check(seed + episodes - 1)  # one seed per episode
    total = episodes * _EPISODE_LENGTH
    with Progress(f"recording {policy}", total=total, unit="control steps") as progress:
        return recording.record(
            environment,
            policy,
            episodes=episodes,
            steps=_EPISODE_LENGTH,
            seed=seed,
            report=progress.advance,
        )


def _save(path: Path | None, command: object, tables: Mapping[str, Table]) -> None:
    if path is not None:
        settings = {
            name: str(value) if isinstance(value, Path) else value
            for name, value in vars(command).items()
            if name != "json"
        }
        files.write_json(path, {"settings": settings, **tables, **surroundings()})


def _error_lines(name: tuple[str, str], windows: Windows) -> Iterator[tuple[str, ...]]:
    for situation, horizon in itertools.product(replay.SITUATIONS, _HORIZONS):
        chosen = windows.situations[horizon - 1] == situation
        if not chosen.any():
            continue
        errors = Errors(*(error[horizon - 1, chosen] for error in windows.errors))
        yield (
            *name,
            situation,
            str(horizon),
            str(chosen.sum()),
            *(
                f"{scale * np.percentile(getattr(errors, field), _PERCENTILE):.2g}"
                for field, scale in _COLUMNS.values()
            ),
            *(_share(errors.cube <= distance) for distance in (_CLOSE, _NEAR)),
        )


def _outcome_line(outcomes: Outcomes) -> tuple[str, ...]:
    return (
        str(len(outcomes.grasped)),
        _share(outcomes.grasped == outcomes.grasped_here),
        _share(outcomes.placed == outcomes.placed_here),
    )


def _pair_line(name: str, successes: Successes) -> tuple[str, ...]:
    *counts, p = closed_loop.compare(successes)
    return (name, *map(str, counts), *map(_share, successes), f"{p:.2g}")


def _share(flags: np.ndarray) -> str:
    return f"{100 * flags.mean():.1f} %"
