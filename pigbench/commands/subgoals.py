"""`pigbench subgoals`: how well a trained hierarchy chooses and reaches its subgoals."""

import dataclasses
from pathlib import Path

import tyro

from pigbench.data import dataset
from pigbench.envs.reality import Reality
from pigbench.errors import UserError, require
from pigbench.seeds import Seed
from pigbench.support import files, memory


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
        from pigbench.agents import FlowHierarchy
        from pigbench.analysis import grasps, subgoals, tables
        from pigbench.runs.restore import restore

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
        stretches = subgoals.draw(data.split("val"), steps, samples=self.samples, seed=self.seed)
        modes, distances = subgoals.measure(env, agent, state.acting, stretches, seed=self.seed)
        parts = [tables.subgoals(modes, distances, steps=steps)]
        before = grasps.draw(
            data.split("val"), agent, env.layout, samples=self.samples, seed=self.seed
        )
        if len(before.starts):
            misses = grasps.measure(agent, state.acting, before, seed=self.seed)
            parts.append(tables.grasps(misses, steps=steps))
        table = "\n".join(parts)
        print(table)
        files.write_text(out, table)
        print(f"wrote the table to {out}")
