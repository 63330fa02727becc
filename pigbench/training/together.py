"""Runs that are trained together, such as the seeds of one program."""

from collections.abc import Sequence

from pigbench.errors import UserError
from pigbench.runs.run import Run


def common_step(runs: Sequence[Run]) -> int | None:
    """The last step of which all runs have a checkpoint; None if none has one after step 0.

    Raises UserError if they have no step in common: some would be trained again from the start.
    """
    saved = [run.saved_steps() for run in runs]
    shared = set.intersection(*saved)
    last = [max(steps, default=0) for steps in saved]
    if not shared and any(last):
        apart: dict[int, list[str]] = {}
        for run, step in zip(runs, last, strict=True):
            if not run.is_trained:
                apart.setdefault(step, []).append(str(run.config.seed))
        seeds = " and ".join(f"--seeds {' '.join(group)}" for group in apart.values())
        reached = ", ".join(
            f"{run.config.seed} (step {step:,})" for run, step in zip(runs, last, strict=True)
        )
        raise UserError(
            f"seeds {reached} have no checkpoint in common to go on from together: ask for {seeds}"
        )
    return max(shared, default=None)
