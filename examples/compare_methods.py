"""Methods on the same data: a table, how probably one is better than another, and curves.

    python examples/compare_methods.py --out runs/compare

generates data, trains each method with each seed, and evaluates them as they learn: some minutes on
two cores. It may be killed, and goes on where it was when it is run again. Methods of a file of
your own are compared by `--plugin FILE --methods gcbc mine`.
"""

import dataclasses
from pathlib import Path

import tyro

from pigbench import agents, plugins
from pigbench.commands.generate import Generate
from pigbench.commands.train import Train
from pigbench.report import plots, stats, tables
from pigbench.support import files
from pigbench.training.evaluate import Evaluation
from pigbench.training.run import read_run


@dataclasses.dataclass(frozen=True)
class Example:
    """Train methods on the same data, and write table.md and curves.png."""

    out: Path
    """Folder of the runs, the table and the picture."""
    methods: tuple[str, ...] = ("gcbc", "gcivl")
    """Methods; see `pigbench list methods`."""
    plugin: Path | None = None
    """A Python file that registers methods of your own."""
    data: Path = Path("runs/examples-data")
    """Folder of the data set, which is generated if it is not there."""
    episodes: int = 100
    """Episodes of play to generate, of 1,001 rows each."""
    steps: int = 8000
    """Updates of each training."""
    evaluate_every: int = 2000
    """Updates between two evaluations."""
    evaluation_episodes: int = 10
    """Episodes of each task in an evaluation."""
    seeds: tuple[int, ...] = (0, 1, 2)
    """Seeds, each of which is a training of each method."""

    def run(self) -> None:
        """Generate, train, and report."""
        if self.plugin is not None:
            plugins.load_file(self.plugin)
        Generate("cube-single", out=self.data, episodes=self.episodes, validation_episodes=0).run()
        runs = [self._train(method, seed) for method in self.methods for seed in self.seeds]
        results = stats.read_results(map(read_run, runs))
        shown = tables.method_table, tables.improvement_table
        made = [make(results, order=self.methods) for make in shown]
        text = tables.render_all(made, "markdown")
        print(text)
        files.write_text(self.out / "table.md", f"{text}\n")
        plots.plot(results, self.out / "curves.png", order=self.methods)

    def _train(self, method: str, seed: int) -> Path:
        """The folder of a finished run."""
        folder = self.out / f"{method}-{seed}"
        Train(
            method,
            data=self.data,
            out=folder,
            agent=agents.get(method).preset("cpu"),
            preset="cpu",
            goals="cubes",
            seed=seed,
            steps=self.steps,
            evaluate_every=self.evaluate_every,
            evaluation=Evaluation(self.evaluation_episodes),
        ).run()
        return folder


if __name__ == "__main__":
    tyro.cli(Example).run()
