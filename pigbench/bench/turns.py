"""Measurements in turns: taken with progress, and saved with their settings."""

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path

from pigbench import provenance
from pigbench.bench.timing import Contender, Timing, alternate
from pigbench.errors import require
from pigbench.support.progress import Progress


@dataclasses.dataclass(frozen=True)
class Turns:
    """How contenders take turns; medians are over turns."""

    turns: int = 5
    """Turns per contender."""
    seconds: float = 2.0
    """Length of a turn in seconds."""

    def __post_init__(self) -> None:
        require(self, lambda x: x >= 1, "at least 1", "turns")
        require(self, lambda x: x > 0, "more than 0", "seconds")


def take_turns(task: str, contenders: Sequence[Contender], turns: Turns) -> Mapping[str, Timing]:
    """Time all contenders, by name, showing progress; compilation is not cached."""
    import jax

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
    """Save a command's settings, all seconds and `more`, if there is a file for them."""
    settings = {name: value for name, value in vars(command).items() if not isinstance(value, Path)}
    settings["turns"] = dataclasses.asdict(settings["turns"])
    seconds = {name: dataclasses.asdict(timing) for name, timing in timings.items()}
    provenance.save(path, settings=settings, seconds=seconds, **more)
