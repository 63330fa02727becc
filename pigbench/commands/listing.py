"""`pigbench list`: environments and methods by name."""

import dataclasses
from collections.abc import Callable

import tyro

from pigbench import agents, envs
from pigbench.errors import lookup


def _environments() -> list[tuple[str, str]]:
    return [
        (
            name,
            ", ".join(
                f"{count} {noun}{'s' * (count > 1)}"
                for noun, count in {
                    "cube": spec.num_cubes,
                    "task": len(spec.tasks),
                    "step": spec.episode_length,
                }.items()
            ),
        )
        for name, spec in envs.SPECS.items()
    ]


def _methods() -> list[tuple[str, str]]:
    return list(agents.summaries().items())


_TOPICS: dict[str, Callable[[], list[tuple[str, str]]]] = {
    "envs": _environments,
    "methods": _methods,
}


@dataclasses.dataclass(frozen=True)
class List:
    """List environments or methods by name."""

    topic: tyro.conf.Positional[str]
    """envs or methods."""

    def run(self) -> None:
        """Print one line per name."""
        rows = lookup("topic", _TOPICS, self.topic)()
        width = max(len(name) for name, _ in rows)
        for name, summary in rows:
            print(f"{name:{width}}  {summary}")
