"""A batch of environments, simulated at once."""

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from gymnasium import error
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from jaxtyping import Bool, Float, Shaped

from pigbench.envs import State, trees
from pigbench.errors import UserError
from pigbench.gym.simulation import (
    METADATA,
    RESET_OPTIONS,
    CompiledEnv,
    known_options,
    observations,
)
from pigbench.support.pictures import Picture

_NEVER = -1  # Gymnasium's time limit for none


class BatchEnv(VectorEnv):
    """A `gymnasium.vector.VectorEnv` without autoreset: an episode that is over stays as it is.

    `reset` takes the options `task_id`, one for all or one per environment, and `reset_mask`
    of the environments to restart, by default all. Otherwise like `SingleEnv`, with one
    value per environment; with `render_goal`, "goal_rendered" shows all goals. A time limit of -1
    is none, as in `gymnasium.make`.

    Raises UserError for a number of environments or a time limit that cannot be.
    """

    metadata = METADATA | {"autoreset_mode": AutoresetMode.DISABLED}

    def __init__(
        self,
        name: str,
        num_envs: int = 1,
        *,
        max_episode_steps: int | None = None,
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        if num_envs < 1:
            raise UserError(f"num_envs is {num_envs}: it must be at least 1")
        if max_episode_steps is not None and max_episode_steps < 1 and max_episode_steps != _NEVER:
            raise UserError(
                f"max_episode_steps is {max_episode_steps}: it must be at least 1, or {_NEVER} for "
                "no limit"
            )
        self._simulation = CompiledEnv(name, render_mode=render_mode, **options)
        self.task_infos = self._simulation.task_infos
        self.num_tasks = len(self.task_infos)
        self.num_envs = num_envs
        self.single_observation_space = self._simulation.observation_space
        self.single_action_space = self._simulation.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.render_mode = render_mode
        limit = max_episode_steps or self._simulation.env.episode_length
        self._limit = np.inf if limit == _NEVER else limit
        self._lengths = np.zeros(num_envs, np.int64)
        self._states: State | None = None

    def reset(
        self,
        *,
        seed: int | np.integer | Sequence[int] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Float[np.ndarray, "simulation observation"], dict[str, Any]]:
        """Start a task in every environment, or in those of the mask.

        Raises UserError for an invalid seed, task id or mask, or an unknown option.
        """
        if not isinstance(seed, int | np.integer | None):
            raise UserError(f"seed is {seed!r}: it must be one integer for all environments")
        super().reset(seed=None if seed is None else int(seed))
        asked = known_options(options, (*RESET_OPTIONS, "reset_mask"))
        tasks = self._simulation.tasks(self.np_random, asked, self.num_envs)
        keys = self._simulation.keys(self.np_random, self.num_envs)
        fresh = self._simulation.reset(keys, tasks)
        anew = self._mask(asked.get("reset_mask", np.ones(self.num_envs, bool)))
        if self._states is not None:
            fresh = _choose(jnp.asarray(anew), fresh, self._states)
        self._states, self._lengths = fresh, np.where(anew, 0, self._lengths)
        extra = {}
        if asked.get("render_goal", False):
            draw = self._simulation.draw_goal
            extra["goal_rendered"] = np.stack([draw(fresh, i) for i in range(self.num_envs)])
        return observations(fresh), self._info(fresh, **extra)

    def step(
        self, actions: object
    ) -> tuple[
        Float[np.ndarray, "simulation observation"],
        Float[np.ndarray, "simulation"],
        Bool[np.ndarray, "simulation"],
        Bool[np.ndarray, "simulation"],
        dict[str, Any],
    ]:
        """Do one control step of 0.05 s in the episodes that are not over."""
        states = self._begun()
        over = np.asarray(states.done, bool) | (self._lengths >= self._limit)
        after = self._simulation.step(states, self._simulation.actions(actions, self.num_envs))
        states = _choose(jnp.asarray(over), states, after)
        self._states, self._lengths = states, self._lengths + ~over
        info = self._info(states)
        late = (self._lengths >= self._limit) & ~info["success"]
        truncated = np.asarray(states.info["diverged"]) | late
        return observations(states), np.asarray(states.reward), info["success"], truncated, info

    def render(self) -> tuple[Picture, ...] | None:
        """One picture per environment, or None without a render mode."""
        if self.render_mode is None:
            return None
        return tuple(self._simulation.draw(self._begun(), i) for i in range(self.num_envs))

    def close_extras(self, **kwargs: Any) -> None:
        """Release the renderer's resources."""
        self._simulation.close()

    def _mask(self, given: object) -> Bool[np.ndarray, "simulation"]:
        mask = np.asarray(given)
        if mask.dtype != bool or mask.shape != (self.num_envs,):
            raise UserError(
                f"reset_mask is {mask.dtype} of shape {mask.shape}: it must be bool of shape "
                f"({self.num_envs},)"
            )
        return mask

    def _begun(self) -> State:
        if self._states is None:
            raise error.ResetNeeded("call reset first")
        return self._states

    def _info(self, states: State, **extra: Shaped[np.ndarray, "simulation ..."]) -> dict[str, Any]:
        info = {
            **extra,
            "goal": self._simulation.goals(states),
            "success": np.asarray(states.info["success"]),
            "task_id": np.asarray(states.info["task"]),
        }
        return info | {f"_{name}": np.ones(self.num_envs, bool) for name in info}


# For each environment, one of two states.
_choose = jax.jit(jax.vmap(trees.where))
