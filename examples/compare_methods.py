"""Compare methods on the same data: a table, probabilities of improvement, and learning curves.

    python examples/compare_methods.py --out runs/compare

generates data, trains each method with each seed, and evaluates them during training, which takes a
few minutes on two cores. If it is killed, it continues where it was when it is run again. To
compare methods from a file of your own, use `--plugin FILE --methods gcbc mine`.
"""

import dataclasses
from pathlib import Path

from pigbench import agents, cli, plugins
from pigbench.commands.generate import Generate
from pigbench.commands.train import Train
from pigbench.evaluation.settings import Evaluation
from pigbench.report import plots, stats, tables
from pigbench.runs.run import read_run
from pigbench.seeds import Seed
from pigbench.support import files


@dataclasses.dataclass(frozen=True)
class Example:
    """Train methods on the same data, and write table.md and curves.png."""

    out: Path
    """Folder for the runs, the table and the plot."""
    methods: tuple[str, ...] = ("gcbc", "gcivl")
    """Methods; see `pigbench list methods`."""
    plugin: Path | None = None
    """A Python file that registers methods of your own."""
    data: Path = Path("runs/examples-data")
    """Folder of the data set, which is generated if it does not exist."""
    episodes: int = 100
    """Episodes of play data to generate, of 1,001 rows each."""
    steps: int = 8000
    """Updates per training run."""
    evaluate_every: int = 2000
    """Updates between evaluations."""
    evaluation_episodes: int = 10
    """Episodes of each task per evaluation."""
    seeds: tuple[Seed, ...] = (0, 1, 2)
    """Seeds; each method is trained with each."""

    def run(self) -> None:
        """Generate data, train, and report."""
        if self.plugin is not None:
            plugins.load_file(self.plugin)
        trainings = [self._training(method, seed) for method in self.methods for seed in self.seeds]
        Generate("cube-single", out=self.data, episodes=self.episodes, validation_episodes=0).run()
        for training in trainings:
            training.run()
        results = stats.read_results(read_run(training.out) for training in trainings)
        shown = tables.method_table, tables.improvement_table
        made = [make(results, order=self.methods) for make in shown]
        text = tables.render_all(made, "markdown")
        print(text)
        files.write_text(self.out / "table.md", f"{text}\n")
        plots.plot(results, self.out / "curves.png", order=self.methods)

    def _training(self, method: str, seed: int) -> Train:
        return Train(
            method,
            data=self.data,
            out=self.out / f"{method}-{seed}",
            agent=agents.get(method).preset("cpu", goals="cubes"),
            preset="cpu",
            seed=seed,
            steps=self.steps,
            evaluate_every=self.evaluate_every,
            evaluation=Evaluation(self.evaluation_episodes),
        )


if __name__ == "__main__":
    cli.script(Example)
