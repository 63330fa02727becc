"""How a suite in a folder may change: it may grow."""

import dataclasses
from pathlib import Path

from pigbench.errors import UserError
from pigbench.suite import spec
from pigbench.suite.spec import Suite
from pigbench.support.compare import require_same


def require_grown(suite: Suite, out: Path) -> None:
    """Raise UserError unless `suite` extends the one kept in the folder `out`, if there is one.

    A suite may grow along its axes, train longer and change its noise levels; the other settings
    its cells share must stay.
    """
    if not (out / spec.KEPT).exists():
        return
    kept = spec.read_kept(out / spec.KEPT)
    asked = {environment.name: environment.steps for environment in suite.environments}
    for environment in kept.environments:
        if asked.get(environment.name, environment.steps) < environment.steps:
            raise UserError(
                f"{out} trains {environment.steps:,} steps on {environment.name}, and not fewer: "
                "ask for as many or more, or choose another folder"
            )
    stored, wanted = (_settings(kept), _settings(suite))
    common = {key for key in stored if key in wanted}
    require_same(
        str(out),
        {key: stored[key] for key in sorted(common)},
        {key: wanted[key] for key in sorted(common)},
    )


def _settings(suite: Suite) -> dict[str, object]:
    settings: dict[str, object] = {
        "preset": suite.preset,
        "data": dataclasses.asdict(suite.data),
        "evaluation": {"every": suite.evaluation.every, "episodes": suite.evaluation.episodes},
        "agent": suite.agent,
    }
    for environment in suite.environments:
        settings[environment.name] = {
            "transitions": environment.transitions,
            "data": str(environment.data),
        }
    return settings | {f"variants.{name}": fields for name, fields in suite.variants.items()}
