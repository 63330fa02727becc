"""One environment, as OGBench's evaluation uses it."""

from typing import Any

import gymnasium
import jax
import numpy as np
from jaxtyping import Float

from pigbench.envs import State
from pigbench.gym.simulation import (
    METADATA,
    RESET_OPTIONS,
    CompiledEnv,
    known_options,
    observations,
)
from pigbench.support.pictures import Picture


class SingleEnv(gymnasium.Env):
    """A `gymnasium.Env`. Its time limit is enforced by `gymnasium.make`'s wrapper.

    `reset` takes the options `task_id`, from 1 to the number of tasks and drawn by default, and
    `render_goal`; its `info` has "goal", and "goal_rendered" if requested. `step` rewards success
    with 1, which ends the episode; a diverging simulation truncates it. `task_infos` lists the
    tasks. The constructor's options are those of `CompiledEnv`.
    """

    metadata = METADATA

    def __init__(self, name: str, *, render_mode: str | None = None, **options: Any) -> None:
        self._simulation = CompiledEnv(name, render_mode=render_mode, **options)
        self.task_infos = self._simulation.task_infos
        self.num_tasks = len(self.task_infos)
        self.observation_space = self._simulation.observation_space
        self.action_space = self._simulation.action_space
        self.render_mode = render_mode
        self._states: State | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Float[np.ndarray, "observation"], dict[str, Any]]:
        """Start a task. Raises UserError for an invalid task id or an unknown option."""
        super().reset(seed=seed)
        asked = known_options(options, RESET_OPTIONS)
        tasks = self._simulation.tasks(self.np_random, asked, 1)
        states: State = self._simulation.reset(self._simulation.keys(self.np_random, 1), tasks)
        self._states = states
        info = self._info(states)
        if asked.get("render_goal", False):
            info["goal_rendered"] = self._simulation.draw_goal(states, 0)
        return observations(states)[0], info

    def step(
        self, action: object
    ) -> tuple[Float[np.ndarray, "observation"], float, bool, bool, dict[str, Any]]:
        """Do one control step of 0.05 s."""
        actions = self._simulation.actions([action], 1)
        states: State = self._simulation.step(self._begun(), actions)
        self._states = states
        info = self._info(states)
        truncated = bool(states.info["diverged"][0])
        return observations(states)[0], float(states.reward[0]), info["success"], truncated, info

    def render(self) -> Picture | None:
        """A picture of the state, or None without a render mode."""
        return None if self.render_mode is None else self._simulation.draw(self._begun(), 0)

    def close(self) -> None:
        """Release the renderer's resources."""
        self._simulation.close()

    def _begun(self) -> State:
        if self._states is None:
            raise gymnasium.error.ResetNeeded("call reset first")
        return self._states

    def _info(self, states: State) -> dict[str, Any]:
        success, task = jax.device_get((states.info["success"][0], states.info["task"][0]))
        goal = self._simulation.goals(states)[0]
        return {"goal": goal, "success": bool(success), "task_id": int(task)}
