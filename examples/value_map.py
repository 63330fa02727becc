"""Draw value functions: V(s, g) over the cube's position on the table.

    python examples/value_map.py runs/compare/gcivl-0 --out values.png

draws a panel for each run. All states of a panel have the same arm pose and goal, with the gripper
open above the table. If there are several cubes, the first one is moved and the others are at their
targets. A good value decreases with the distance to the goal, which is marked by a star.
"""

import dataclasses
from pathlib import Path
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import tyro

from pigbench import cli, seeds
from pigbench.envs import workspace
from pigbench.envs.cubes import CUBE_HALF_SIZE
from pigbench.errors import UserError, require
from pigbench.report import canvas
from pigbench.runs.restore import restore
from pigbench.seeds import Seed


class Map(NamedTuple):
    """Values (X, Y) of the cube at x (X,) and y (Y,), metres, for its target at `goal` (2,)."""

    title: str
    x: np.ndarray
    y: np.ndarray
    values: np.ndarray
    goal: np.ndarray


def value_map(folder: Path, *, task: int, points: int, seed: int) -> Map:
    """V of a run's last checkpoint, at `points` positions along each side of the table."""
    run, env, agent, state = restore(folder)
    env.check_task(task)
    goal = env.spec.tasks[task - 1].goal_xyz
    x, y = np.linspace(workspace.CUBE.low, workspace.CUBE.high, points).T

    def value(first_x: jax.Array, first_y: jax.Array) -> jax.Array:
        cubes = jnp.asarray(goal).at[0].set(jnp.array([first_x, first_y, CUBE_HALF_SIZE]))
        yaw = jnp.zeros(env.spec.num_cubes)
        # One key for all, so that all states have the same arm pose and the same goal.
        start = env.reset_to(seeds.key(seed), cubes, goal, yaw=yaw, jitter=0.0)
        return agent.state_value(state.acting, start.obs, start.info["goal"])

    values = jax.jit(jax.vmap(value))(*map(jnp.ravel, jnp.meshgrid(x, y, indexing="ij")))
    title = f"{run.config.label}, seed {run.config.seed}, step {int(state.step):,}"
    return Map(title, x, y, np.asarray(values).reshape(points, points), goal[0, :2])


def draw(maps: list[Map], path: Path) -> None:
    """Draw a panel for each map, seen from above with the robot at the bottom."""
    with canvas.look():
        figure, panels = canvas.grid(1, len(maps), panel=(4.2, 2.0), legend=[], share_y=False)
        for panel, one in zip(panels[0], maps, strict=True):
            shown = panel.contourf(one.y, one.x, one.values, levels=20, cmap="viridis")
            panel.plot(*one.goal[::-1], "*", color="white", markeredgecolor="black", markersize=12)
            panel.set(title=one.title, xlabel="y of the cube (m)", ylabel="x of the cube (m)")
            panel.invert_xaxis()  # the robot's left is on the left
            panel.set_aspect("equal")
            panel.grid(visible=False)
            figure.colorbar(shown, ax=panel, label="V(s, g)", shrink=0.6)
        canvas.save(figure, path)


@dataclasses.dataclass(frozen=True)
class Example:
    """Draw the values of runs over the position of a cube."""

    runs: tyro.conf.Positional[tuple[Path, ...]]
    """Folders of runs of methods that learn a value."""
    out: Path
    """File for the picture."""
    task: int = 4
    """Task that gives the goal."""
    points: int = 41
    """Positions along each side of the table."""
    seed: Seed = 0
    """Seed of the arm's poses."""

    def __post_init__(self) -> None:
        if not self.runs:
            raise UserError("no runs are given: name their folders")
        require(self, lambda x: x >= 2, "at least 2", "points")

    def run(self) -> None:
        """Evaluate and draw."""
        canvas.check_path(self.out)
        maps = [
            value_map(folder, task=self.task, points=self.points, seed=self.seed)
            for folder in self.runs
        ]
        draw(maps, self.out)
        for one in maps:
            best = np.unravel_index(one.values.argmax(), one.values.shape)
            away = np.hypot(one.x[best[0]] - one.goal[0], one.y[best[1]] - one.goal[1])
            print(f"{one.title}: the maximum is {100 * away:.1f} cm from the goal")


if __name__ == "__main__":
    cli.script(Example)
