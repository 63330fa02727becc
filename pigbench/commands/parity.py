"""`pigbench parity`: how far OGBench's own episodes take our simulations from OGBench's."""

import dataclasses
import itertools
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import tyro

from pigbench import envs
from pigbench.errors import UserError
from pigbench.fidelity import recording, replay
from pigbench.fidelity.replay import Errors, Outcomes, Windows
from pigbench.report.formats import markdown_grid
from pigbench.support import files
from pigbench.support.progress import Progress
from pigbench.training.provenance import surroundings

_EPISODE_LENGTH = 1000  # control steps
_HORIZONS = (1, 10, replay.WINDOW)  # control steps after which errors are compared
_PERCENTILE = 95
_CLOSE, _NEAR = 1e-4, 2e-3  # metres

# Column -> the error, and by what it is multiplied there.
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

    Its own scripted policy acts in its own physics; the same actions are applied here, over
    stretches of 50 control steps and over whole sub-tasks.
    """

    environment: tyro.conf.Positional[str] = "cube-double"
    """Environment."""
    policy: str = "play"
    """Scripted policy of OGBench's: play or noisy."""
    episodes: int = 20
    """Episodes of 1,000 control steps."""
    seed: int = 0
    """Seed of the episodes."""
    engine: tuple[str, ...] = dataclasses.field(default_factory=lambda: (envs.default_engine(),))
    """Physics engines."""
    physics: tuple[str, ...] = ("exact", "fast")
    """Physics profiles."""
    json: Path | None = None
    """File for the result as JSON, with machine and versions."""

    def run(self) -> None:
        """Measure and print a table of errors, and one of outcomes."""
        if self.episodes < 1:
            raise UserError(f"episodes is {self.episodes}: it must be at least 1")
        ours = {
            (engine, profile): envs.make(self.environment, engine=engine, profile=profile)
            for engine, profile in itertools.product(self.engine, self.physics)
        }
        total = self.episodes * _EPISODE_LENGTH
        with Progress("recording", total=total, unit="control steps") as progress:
            recordings = recording.record(
                self.environment,
                self.policy,
                episodes=self.episodes,
                steps=_EPISODE_LENGTH,
                seed=self.seed,
                report=progress.advance,
            )
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
        print(f"\nErrors: {_PERCENTILE}th percentiles over windows, of cubes the farthest.\n")
        print(markdown_grid(end_table))
        if self.json is not None:
            settings = {name: value for name, value in vars(self).items() if name != "json"}
            tables = {"errors": error_table, "outcomes": end_table}
            files.write_json(self.json, {"settings": settings, **tables, **surroundings()})


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


def _share(flags: np.ndarray) -> str:
    return f"{100 * flags.mean():.1f} %"
