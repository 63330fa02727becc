"""The Gymnasium interface: a short NumPy controller that sees only observations.

    python examples/gymnasium_control.py --out runs/gymnasium

runs it in a batch of environments and prints its success rate on each task. It then runs it in a
single environment and draws that episode, starting with the goal.
"""

import dataclasses
import itertools
from pathlib import Path

import gymnasium
import numpy as np

from pigbench import cli  # pigbench registers its environments with Gymnasium
from pigbench.envs.terms import layout
from pigbench.envs.units import ACTION_SCALE, metres
from pigbench.errors import require
from pigbench.seeds import Seed
from pigbench.support import files, pictures

ENVIRONMENT, TASKS = "pigbench/cube-single-v0", 5
LAYOUT = layout(num_cubes=1)
LONGEST_MOVE, LARGEST_TURN = ACTION_SCALE[0], ACTION_SCALE[3]  # in metres and radians
OPEN, SHUT = -1.0, 1.0
HOVER = 0.1  # metres above a cube at which the gripper travels


def control(observations: np.ndarray, goals: np.ndarray) -> np.ndarray:
    """Actions (B, 5) that bring the cube to its goal, from observations (B, o) of both."""

    def term(values: np.ndarray, name: str) -> np.ndarray:
        return values[:, LAYOUT[name]]

    pinch, cube = (metres(term(observations, n)) for n in ("effector_pos", "cube_0_pos"))
    goal = metres(term(goals, "cube_0_pos"))
    up = np.array([0.0, 0.0, HOVER])

    def near(a: np.ndarray, b: np.ndarray, within: float) -> np.ndarray:
        return np.linalg.norm(a - b, axis=-1, keepdims=True) < within

    between = near(pinch, cube, 0.015)
    held = near(pinch, cube, 0.03) & (term(observations, "gripper_contact") > 0.1)
    above_cube = near(pinch[:, :2], cube[:, :2], 0.01)
    above_goal = near(pinch[:, :2], goal[:, :2], 0.01)
    high = pinch[:, 2:] > 0.8 * HOVER
    carry = np.where(above_goal, goal, np.where(high, goal + up, pinch + up))
    fetch = np.where(above_cube, cube, cube + up)
    move = (np.where(held, carry, fetch) - pinch) / LONGEST_MOVE
    turn = _quarter(_angle(term(observations, "cube_0_yaw"), term(observations, "effector_yaw")))
    grip = np.where(held | between, SHUT, OPEN)
    return np.clip(np.concatenate([move, turn / LARGEST_TURN, grip], axis=-1), -1.0, 1.0)


def _angle(to: np.ndarray, of: np.ndarray) -> np.ndarray:
    """The angle (B, 1) between directions given as cosines and sines (B, 2)."""
    return np.arctan2(*to.T[::-1])[:, None] - np.arctan2(*of.T[::-1])[:, None]


def _quarter(angle: np.ndarray) -> np.ndarray:
    """The smallest rotation with the same effect on a cube's sides."""
    return (angle + np.pi / 4) % (np.pi / 2) - np.pi / 4


@dataclasses.dataclass(frozen=True)
class Example:
    """Run a controller through Gymnasium, in a batch and in a single environment."""

    out: Path
    """Folder for the picture and the results."""
    episodes: int = 20
    """Episodes of each task in the batch."""
    task: int = 4
    """Task of the episode in the picture."""
    every: int = 12
    """Control steps between two frames of the episode."""
    seed: Seed = 0
    """Random seed."""

    def __post_init__(self) -> None:
        require(self, lambda x: x >= 1, "at least 1", "episodes", "every")
        require(self, lambda x: 1 <= x <= TASKS, f"from 1 to {TASKS}", "task")

    def run(self) -> None:
        """Run the controller, print the results, and draw an episode."""
        files.require_folder(self.out)
        lines = self._batch()
        print("\n".join(lines))
        files.write_text(self.out / "results.txt", "\n".join(lines) + "\n")
        pictures.write_png(self.out / "episode.png", self._single())

    def _batch(self) -> list[str]:
        """A line for each task."""
        tasks = np.repeat(np.arange(1, TASKS + 1), self.episodes)
        batch = gymnasium.make_vec(ENVIRONMENT, num_envs=len(tasks))
        observations, info = batch.reset(seed=self.seed, options={"task_id": tasks})
        lengths, over = np.zeros(len(tasks), int), np.zeros(len(tasks), bool)
        while not over.all():  # an episode that is over does not change
            lengths += ~over
            actions = control(observations, info["goal"])
            observations, _, terminated, truncated, info = batch.step(actions)
            over = terminated | truncated
        batch.close()
        return [
            f"task {task}: {100 * info['success'][tasks == task].mean():.0f} % of "
            f"{self.episodes} episodes succeed, after {lengths[tasks == task].mean():.0f} steps"
            for task in np.unique(tasks)
        ]

    def _single(self) -> np.ndarray:
        """The goal and the episode, side by side."""
        env = gymnasium.make(ENVIRONMENT, render_mode="rgb_array")
        options = {"task_id": self.task, "render_goal": True}
        observation, info = env.reset(seed=self.seed, options=options)
        film = [info["goal_rendered"], env.render()]
        for step in itertools.count(1):
            (action,) = control(observation[None], info["goal"][None])
            observation, _, terminated, truncated, info = env.step(action)
            over = terminated or truncated
            if over or step % self.every == 0:
                film.append(env.render())
            if over:
                break
        env.close()
        margin = (0, 0), (0, 4), (0, 0)
        return np.concatenate([np.pad(one, margin, constant_values=255) for one in film], axis=1)


if __name__ == "__main__":
    cli.script(Example)
