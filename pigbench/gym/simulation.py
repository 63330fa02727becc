"""What one environment and a batch have in common: spaces, goal representations and pictures."""

from collections.abc import Iterable, Mapping
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from gymnasium import spaces
from jaxtyping import Array, Float, Int, Key

from pigbench import envs, seeds
from pigbench.agents.goals import GOALS
from pigbench.agents.representations import Representation
from pigbench.envs import State
from pigbench.envs.rendering import Renderer
from pigbench.envs.units import CONTROL_STEP, metres
from pigbench.errors import UserError, lookup
from pigbench.support.pictures import Picture

RENDER_MODE = "rgb_array"
RESET_OPTIONS = ("task_id", "render_goal")

METADATA = {"render_modes": [RENDER_MODE], "render_fps": round(1 / CONTROL_STEP)}


class CompiledEnv:
    """An environment's compiled functions and its spaces.

    `goals` is the representation of goals: the whole state ("state") or the cubes' positions
    ("cubes"). Pictures are `height` by `width` pixels.

    Raises UserError for an unknown environment, engine, profile, kind of goals or render mode.
    """

    def __init__(
        self,
        name: str,
        *,
        engine: str | None = None,
        profile: str = "exact",
        goals: str = "state",
        render_mode: str | None = None,
        height: int = 200,
        width: int = 200,
    ) -> None:
        if render_mode not in (None, RENDER_MODE):
            raise UserError(f"render_mode is {render_mode!r}: it must be None or {RENDER_MODE!r}")
        lookup("goals", GOALS, goals)
        self.env = envs.make(name, engine=engine, profile=profile)
        self.represent = Representation(goals, self.env.layout, table=GOALS)
        self.observation_space = spaces.Box(
            -np.inf, np.inf, (self.env.observation_size,), np.float32
        )
        self.action_space = spaces.Box(-1.0, 1.0, (self.env.action_size,), np.float32)
        self.reset = jax.jit(jax.vmap(self.env.reset_task))
        self.step = jax.jit(jax.vmap(self.env.step))
        self._height, self._width = height, width
        self._renderer: Renderer | None = None

    @property
    def task_infos(self) -> list[dict[str, Any]]:
        """The tasks in order, in OGBench's form; positions are in metres, one row per cube."""
        return [
            {"task_name": task.name, "init_xyzs": task.start_xyz, "goal_xyzs": task.goal_xyz}
            for task in self.env.spec.tasks
        ]

    def keys(self, draws: np.random.Generator, count: int) -> Key[Array, "simulation"]:
        """`count` random keys."""
        return jax.random.split(seeds.key(int(draws.integers(2**32))), count)

    def tasks(
        self, draws: np.random.Generator, options: Mapping[str, Any], count: int
    ) -> Int[np.ndarray, "simulation"]:
        """`count` task ids from `options`, or else drawn. Raises UserError for invalid ids."""
        last = self.env.num_tasks
        if "task_id" not in options:
            return draws.integers(1, last + 1, count)
        tasks = np.asarray(options["task_id"])
        known = np.issubdtype(tasks.dtype, np.integer) and np.all((tasks >= 1) & (tasks <= last))
        if not known or tasks.shape not in ((), (count,)):
            raise UserError(
                f"task_id is {options['task_id']!r}: {self.env.spec.name} has tasks 1 to {last}, "
                "and takes one id for all environments or one for each"
            )
        return np.broadcast_to(tasks, (count,))

    def actions(self, given: object, count: int) -> Float[np.ndarray, "simulation action"]:
        """`given` as an array of `count` actions. Raises UserError for another shape."""
        actions, shape = np.asarray(given, np.float32), (count, self.env.action_size)
        if actions.shape != shape:
            raise UserError(f"actions have shape {actions.shape}: it must be {shape}")
        return actions

    def goals(self, states: State) -> Float[np.ndarray, "simulation goal"]:
        """The goals' representations."""
        return np.asarray(self.represent(states.info["goal"]))

    def draw(self, states: State, index: int) -> Picture:
        """A picture of a state with a translucent goal."""
        target = np.asarray(states.info["target"][index])
        return self._draw(np.asarray(self.env.simulation(states).qpos[index]), target)

    def draw_goal(self, states: State, index: int) -> Picture:
        """A picture of the goal: its arm and cubes, with the gripper open."""
        goal, layout, scene = states.info["goal"][index], self.env.layout, self.env.scene
        cubes = jnp.concatenate(
            [
                part
                for cube in range(scene.num_cubes)
                for part in (
                    metres(goal[layout[f"cube_{cube}_pos"]]),
                    goal[layout[f"cube_{cube}_quat"]],
                )
            ]
        )
        qpos = jnp.asarray(scene.home_qpos).at[scene.arm].set(goal[layout["joint_pos"]])
        return self._draw(np.asarray(qpos.at[scene.cubes_qpos].set(cubes)), None)

    def close(self) -> None:
        """Release the renderer's resources."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    def _draw(
        self, qpos: Float[np.ndarray, "nq"], target: Float[np.ndarray, "cube 3"] | None
    ) -> Picture:
        if self._renderer is None:
            self._renderer = Renderer(
                self.env.spec.num_cubes, height=self._height, width=self._width
            )
        return self._renderer.draw(qpos, target)


def known_options(given: Mapping[str, Any] | None, names: Iterable[str]) -> Mapping[str, Any]:
    """The options of a reset. Raises UserError for one whose name is not in `names`."""
    for name in given or {}:
        lookup("option of reset", dict.fromkeys(names), name)
    return given or {}


def observations(states: State) -> Float[np.ndarray, "simulation observation"]:
    """The observations of a batch."""
    return np.asarray(states.obs)
