"""`pigbench parity`: how close our simulations and the data made in them are to OGBench's."""

import dataclasses
import itertools
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from pigbench import envs, provenance, seeds
from pigbench.data.defaults import EPISODE_ROWS
from pigbench.errors import UserError
from pigbench.evaluation.settings import Evaluation
from pigbench.report.formats import markdown_grid
from pigbench.seeds import Seed
from pigbench.support import files
from pigbench.support.progress import Progress

if TYPE_CHECKING:
    from pigbench.fidelity.recording import PeerRecording
    from pigbench.fidelity.tables import FidelityTable

_EPISODE_LENGTH = EPISODE_ROWS - 1  # control steps


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
    engine: tuple[str, ...] = ()
    """Physics engines, by default the one for this device."""
    physics: tuple[str, ...] = ("exact", "fast")
    """Physics profiles."""
    json: Path | None = None
    """File for the result as JSON, with the machine and versions."""

    def run(self) -> None:
        """Measure, and print a table of errors and one of outcomes."""
        from pigbench.fidelity import replay, tables

        files.require_files(self.json)
        engines = self.engine or (envs.default_engine(),)
        ours = {
            (engine, profile): envs.make(self.environment, engine=engine, profile=profile)
            for engine, profile in itertools.product(engines, self.physics)
        }
        recordings = _record(self.environment, self.policy, self.episodes, self.seed)
        windows, outcomes = {}, {}
        with Progress("replaying", total=len(ours), unit="simulators") as progress:
            for name, env in ours.items():
                windows[name] = replay.windows(env, recordings)
                outcomes[name] = replay.outcomes(env, recordings)
                progress.advance(1, ", ".join(name))
        error_table, end_table = tables.errors(windows), tables.outcomes(outcomes)
        print(markdown_grid(error_table))
        print(f"\nErrors: {tables.PERCENTILE}th percentiles over windows, for the farthest cube.\n")
        print(markdown_grid(end_table))
        command = dataclasses.replace(self, engine=engines)
        _save(self.json, command, errors=error_table, outcomes=end_table)


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
    engine: str | None = None
    """Physics engine, by default the one for this device."""
    physics: str = "exact"
    """Physics profile."""
    json: Path | None = None
    """File for the result as JSON, with the machine and versions."""

    def run(self) -> None:
        """Measure and print a table."""
        from pigbench.fidelity import distributions, tables

        files.require_files(self.json)
        env = envs.make(self.environment, engine=self.engine, profile=self.physics)
        compared = []
        for policy in self.policies:
            recordings = _record(self.environment, policy, self.episodes, self.seed)
            theirs = [distributions.of_recording(env.scene, one) for one in recordings]
            ours = distributions.simulate(
                env, policy, episodes=self.episodes, steps=_EPISODE_LENGTH, seed=self.seed
            )
            compared.append((policy, distributions.compare(theirs, ours)))
        table = tables.quantities(compared)
        print(markdown_grid(table))
        print(f"\nMeans over {self.episodes} episodes each; the test compares the episodes' means.")
        _save(self.json, dataclasses.replace(self, engine=env.backend), quantities=table)


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
        from pigbench.fidelity import closed_loop, peer, tables
        from pigbench.runs.restore import restore

        files.require_files(self.json)
        evaluation = Evaluation(self.episodes, self.seed)
        run, env, agent, state = restore(self.run_folder, engine=self.engine)
        total = env.num_tasks * self.episodes
        with Progress(f"acting in {peer.NAME}", total=total, unit="episodes") as progress:
            successes = closed_loop.simulate(env, agent, state.acting, evaluation, progress.reach)
        table = tables.pairs([task.name for task in env.spec.tasks], successes)
        print(markdown_grid(table))
        print(
            f"\nPairs of episodes, and success in each simulator: {run.config.label}, "
            f"{int(state.step):,} updates, {run.config.environment}; physics: "
            f"{run.config.physics}, engine {env.backend}. The test is exact."
        )
        _save(self.json, dataclasses.replace(self, engine=env.backend), pairs=table)


def _record(environment: str, policy: str, episodes: int, seed: int) -> list["PeerRecording"]:
    from pigbench.fidelity import recording

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


def _save(path: Path | None, command: object, **tables: "FidelityTable") -> None:
    settings = {
        name: str(value) if isinstance(value, Path) else value
        for name, value in vars(command).items()
        if name != "json"
    }
    provenance.save(path, settings=settings, **tables)
