"""Train on a log of your own: one CSV file per episode becomes a data set, and then a policy.

    python examples/own_log.py --out runs/own-log

writes logs of simulated episodes as a UR5e's driver would, imports them, trains on them, and
evaluates the policy. With `--logs FOLDER`, it takes your logs instead; docs/robot.md lists the
columns that they need.
"""

import csv
import dataclasses
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from pigbench import agents, cli
from pigbench.commands.data import DataImport
from pigbench.commands.generate import Generate
from pigbench.commands.train import Train
from pigbench.data import dataset
from pigbench.envs.units import CONTROL_STEP, OPENING_SCALE, metres
from pigbench.evaluation.settings import Evaluation
from pigbench.layout import Layout
from pigbench.report import stats, tables
from pigbench.runs.run import read_run
from pigbench.support import files

ENVIRONMENT = "cube-centre"
TO_BASE = Rotation.from_euler("z", 90, degrees=True)
"""From the world frame to that of the robot's controller."""


def log_of(observations: np.ndarray, actions: np.ndarray, layout: Layout) -> dict[str, np.ndarray]:
    """The columns of an episode's log, by name, each (rows,)."""

    def term(name: str) -> np.ndarray:
        return observations[:, layout[name]]

    def numbered(name: str, values: np.ndarray) -> dict[str, np.ndarray]:
        return {f"{name}_{number}": column for number, column in enumerate(values.T)}

    quaternion = TO_BASE * Rotation.from_quat(term("cube_0_quat"), scalar_first=True)
    pose = [TO_BASE.apply(metres(term("cube_0_pos"))), quaternion.as_quat(scalar_first=True)]
    names = ("x", "y", "z", "qw", "qx", "qy", "qz")
    return (
        {"time": CONTROL_STEP * np.arange(len(observations))}
        | numbered("joint_pos", term("joint_pos"))
        | numbered("joint_vel", term("joint_vel"))
        | {"gripper_opening": term("gripper_opening")[:, 0] / OPENING_SCALE}
        | {"gripper_contact": term("gripper_contact")[:, 0]}
        | {f"object_{name}": column for name, column in zip(names, np.hstack(pose).T, strict=True)}
        | numbered("action", actions)
    )


def write_logs(data: dataset.Dataset, folder: Path) -> None:
    """Write a file for each episode of the training split."""
    folder.mkdir(parents=True, exist_ok=True)
    split, number = data.split("train"), 0
    for record in split.records:
        for episode in split.shard_episodes(record, "observations", "actions"):
            columns = log_of(episode["observations"], episode["actions"], data.layout)
            with (folder / f"episode-{number:04}.csv").open("w", newline="") as file:
                writer = csv.writer(file)
                writer.writerow(columns)
                writer.writerows(zip(*columns.values(), strict=True))
            number += 1


@dataclasses.dataclass(frozen=True)
class Example:
    """Import logs, train on them, and report how close to its target the policy brings the cube."""

    out: Path
    """Folder for everything that is written."""
    logs: Path | None = None
    """Folder of your logs; by default, logs of simulated episodes are made."""
    episodes: int = 200
    """Simulated episodes."""
    method: str = "gcivl"
    """Method; see `pigbench list methods`."""
    steps: int = 8000
    """Updates of the training run."""
    evaluation_episodes: int = 50
    """Episodes of the final evaluation."""

    def run(self) -> None:
        """Write logs, import them, train, and report."""
        data = self.out / "data"
        training = Train(
            self.method,
            data=data,
            out=self.out / self.method,
            agent=agents.get(self.method).preset("cpu", goals="cubes"),
            preset="cpu",
            steps=self.steps,
            evaluate_every=self.steps,
            evaluation=Evaluation(self.evaluation_episodes),
        )
        logs = self.logs or self._simulated()
        DataImport((logs,), environment=ENVIRONMENT, out=data, format="log").run()
        training.run()
        results = stats.read_results([read_run(training.out)])
        text = tables.render_all([tables.threshold_table(results)], "markdown")
        print(text)
        files.write_text(self.out / "table.md", f"{text}\n")

    def _simulated(self) -> Path:
        """Write logs of episodes of a scripted policy, and return their folder."""
        simulated, logs = self.out / "simulated", self.out / "logs"
        Generate(ENVIRONMENT, out=simulated, episodes=self.episodes, validation_episodes=0).run()
        write_logs(dataset.load(simulated), logs)
        return logs


if __name__ == "__main__":
    cli.script(Example)
