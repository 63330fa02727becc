"""`pigbench analyze`: residuals of a trained value function by contact mode."""

import dataclasses
from pathlib import Path

import tyro

from pigbench import envs
from pigbench.data import dataset
from pigbench.errors import require
from pigbench.seeds import Seed
from pigbench.support import files, memory
from pigbench.support.lock import only_writer


@dataclasses.dataclass(frozen=True)
class Analyze:
    """Measure a run's value function over a data set, separately for each contact mode.

    The robot's finger pad feels no force (free), or it feels one with a cube between the fingers
    (holding) or without one (touching). Hierarchies are measured at their low level.
    """

    run_folder: tyro.conf.Positional[Path]
    """Folder of the run."""
    data: Path
    """Folder of the data set."""
    out: Path | None = None
    """Folder for the table and the figure; by default `analysis` in the run's folder."""
    samples: int = 20_000
    """Transitions to measure."""
    seed: Seed = 0
    """Seed of the transitions and of their goals."""

    def run(self) -> None:
        """Measure, print the table, and draw the figure."""
        from pigbench.analysis import figure, tables
        from pigbench.analysis.residuals import measure
        from pigbench.data.sampler import Rows
        from pigbench.runs.restore import restore

        require(self, lambda x: x >= 1, "at least 1", "samples")
        memory.require_for(self.samples, "samples")
        out = self.out or self.run_folder / "analysis"
        files.require_folder(out)
        # Nothing is simulated: any engine does, and this machine may lack the run's own.
        run, env, agent, state = restore(self.run_folder, engine=envs.default_engine())
        data = dataset.load(self.data)
        dataset.check_layout(data, env.layout)
        rows = Rows.from_split(data.split("train"))
        with only_writer(out):
            modes, residuals = measure(
                agent, state.acting, rows, samples=self.samples, seed=self.seed
            )
            table = tables.residuals(modes, residuals, agent)
            print(table)
            files.write_text(out / "residuals.md", table)
            title = f"{run.config.label} on {run.config.environment}, step {int(state.step):,}"
            figure.draw(modes, residuals, out / "residuals.png", title=title)
        print(f"wrote the table and the figure to {out}")
