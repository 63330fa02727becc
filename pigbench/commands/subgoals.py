"""`pigbench subgoals`: how well a trained hierarchy reaches its subgoals, and names them."""

import dataclasses
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import tyro

from pigbench.agents import FlowHierarchy
from pigbench.analysis.modes import MODES
from pigbench.analysis.subgoals import Distances, draw, measure
from pigbench.data import dataset
from pigbench.errors import UserError
from pigbench.report.formats import markdown_grid
from pigbench.seeds import Seed
from pigbench.support import files
from pigbench.training.restore import restore

_PERCENTILES = 50, 90
_CAPTION = (
    "Distances in mm between a simulation after K = {steps} control steps and the data then: "
    "medians and 90th percentiles over stretches, by the contact mode that they begin in. The low "
    "level's subgoal is at every step the data's state K steps after it, as in training, or it is "
    "fixed where the stretch ends; both levels have that end as their goal."
)


@dataclasses.dataclass(frozen=True)
class SubgoalErrors:
    """Simulate a hierarchy from states of a data set towards what the data reached K steps later.

    If the low level comes nowhere near, given the data's own subgoals, it is what fails; if it does
    so only with the high level above it, the subgoals are off.
    """

    run_folder: tyro.conf.Positional[Path]
    """Folder of the run."""
    data: Path
    """Folder of the data set, whose validation episodes are used."""
    out: Path | None = None
    """File for the table; by default `analysis/subgoals.md` in the run's folder."""
    samples: int = 500
    """Stretches to simulate."""
    seed: Seed = 0
    """Seed of the stretches, and of what the policies draw."""

    def run(self) -> None:
        """Simulate and print the table."""
        if self.samples < 1:
            raise UserError(f"samples is {self.samples}: it must be at least 1")
        run, env, agent, state = restore(self.run_folder)
        if not isinstance(agent, FlowHierarchy):
            raise UserError(f"{run.config.method} has no flow of subgoals: choose a run that has")
        data = dataset.load(self.data)
        dataset.check_layout(data, env.layout)
        steps = agent.config.subgoal_steps
        stretches = draw(data.split("val"), steps, samples=self.samples, seed=self.seed)
        modes, distances = measure(env, agent, state.params, stretches, seed=self.seed)
        header = ("mode", "stretches", "how", *_columns("pinch"), *_columns("cube"))
        grid = markdown_grid([header, *_lines(modes, distances)])
        table = f"{grid}\n\n{_CAPTION.format(steps=steps)}\n"
        print(table)
        out = self.out or self.run_folder / "analysis" / "subgoals.md"
        out.parent.mkdir(parents=True, exist_ok=True)
        files.write_text(out, table)
        print(f"the table lies in {out}")


def _columns(what: str) -> list[str]:
    return [f"{what} {percentile} %" for percentile in _PERCENTILES]


def _lines(modes: np.ndarray, distances: Mapping[str, Distances]) -> Iterator[tuple[str, ...]]:
    for mode in MODES:
        chosen = modes == mode
        if not chosen.any():
            continue
        for way, apart in distances.items():
            values = (np.percentile(column[chosen], _PERCENTILES) for column in apart)
            millimetres = (f"{1e3 * value:.1f}" for pair in values for value in pair)
            yield mode, str(chosen.sum()), way, *millimetres
