"""`pigbench subgoals`: how well a trained hierarchy chooses and reaches its subgoals."""

import dataclasses
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import tyro
from jaxtyping import Float, Shaped

from pigbench.agents import FlowHierarchy
from pigbench.analysis import grasps
from pigbench.analysis.modes import MODES
from pigbench.analysis.subgoals import Distances, draw, measure
from pigbench.data import dataset
from pigbench.envs.reality import Reality
from pigbench.errors import UserError, require
from pigbench.report.formats import markdown_grid
from pigbench.runs.restore import restore
from pigbench.seeds import Seed
from pigbench.support import files, memory

_PERCENTILES = 50, 90
_CAPTION = (
    "Distances in mm between a simulation after K = {steps} control steps and the data then: "
    "medians and 90th percentiles over stretches, by the contact mode in which they begin. The low "
    "level's subgoal is either the data's state K steps after the current step, as in training, or "
    "fixed at the stretch's end; both levels have that end as their goal."
)
_GRASP_CAPTION = (
    "Distances in mm in x and y from a subgoal's pinch point to the cube: medians and 90th "
    "percentiles over states of the data after which the gripper takes hold of a cube within K = "
    "{steps} control steps, with goals more than 2 K ahead, drawn as in training."
)


@dataclasses.dataclass(frozen=True)
class SubgoalErrors:
    """Measure a hierarchy's subgoals before grasps, and simulate it from states of a data set.

    Given a distant goal, subgoals should be at the cube that is grasped next in the data; the
    gripper tolerates about 20 mm. Simulations aim for the data's state K steps later. If the low
    level gets nowhere near it even with the data's own subgoals, the low level is at fault.
    Environments with a robot's imperfections (cube-centre) are refused: data do not record them.
    """

    run_folder: tyro.conf.Positional[Path]
    """Folder of the run."""
    data: Path
    """Folder of the data set; its validation episodes are used."""
    out: Path | None = None
    """File for the table; by default `analysis/subgoals.md` in the run's folder."""
    samples: int = 500
    """Number of stretches to simulate, and of states before grasps."""
    seed: Seed = 0
    """Seed of both and of the policies' random draws."""

    def run(self) -> None:
        """Simulate and print the table."""
        require(self, lambda x: x >= 1, "at least 1", "samples")
        memory.require_for(self.samples, "samples")
        out = self.out or self.run_folder / "analysis" / "subgoals.md"
        files.require_file(out)
        run, env, agent, state = restore(self.run_folder)
        if not isinstance(agent, FlowHierarchy):
            raise UserError(
                f"{run.config.method} has no flow of subgoals: choose a run that has one"
            )
        if env.reality not in (None, Reality()):  # data record the simulator's state, not more
            raise UserError(
                f"{env.spec.name} delays actions, estimates poses or varies friction and mass, "
                "which data do not record, so that subgoals cannot simulate it from their states: "
                "choose a run in an environment without a reality, such as cube-single"
            )
        data = dataset.load(self.data)
        dataset.check_layout(data, env.layout)
        steps = agent.config.subgoal_steps
        stretches = draw(data.split("val"), steps, samples=self.samples, seed=self.seed)
        modes, distances = measure(env, agent, state.acting, stretches, seed=self.seed)
        header = ("mode", "stretches", "how", *_columns("pinch"), *_columns("cube"))
        grid = markdown_grid([header, *_lines(modes, distances)])
        table = f"{grid}\n\n{_CAPTION.format(steps=steps)}\n"
        before = grasps.draw(
            data.split("val"), agent, env.layout, samples=self.samples, seed=self.seed
        )
        if len(before.starts):
            misses = grasps.measure(agent, state.acting, before, seed=self.seed)
            grid = markdown_grid([("subgoal", "grasps", *_columns("off")), *_grasp_lines(misses)])
            table += f"\n{grid}\n\n{_GRASP_CAPTION.format(steps=steps)}\n"
        print(table)
        files.write_text(out, table)
        print(f"wrote the table to {out}")


def _columns(what: str) -> list[str]:
    return [f"{what} {percentile} %" for percentile in _PERCENTILES]


def _lines(
    modes: Shaped[np.ndarray, "batch"], distances: Mapping[str, Distances]
) -> Iterator[tuple[str, ...]]:
    for mode in MODES:
        chosen = modes == mode
        if not chosen.any():
            continue
        for way, apart in distances.items():
            yield mode, str(chosen.sum()), way, *_millimetres(*(x[chosen] for x in apart))


def _grasp_lines(misses: Mapping[str, Float[np.ndarray, "batch"]]) -> Iterator[tuple[str, ...]]:
    for whose, distances in misses.items():
        yield whose, str(len(distances)), *_millimetres(distances)


def _millimetres(*columns: Float[np.ndarray, "batch"]) -> list[str]:
    return [f"{1e3 * x:.1f}" for column in columns for x in np.percentile(column, _PERCENTILES)]
