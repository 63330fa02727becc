"""The interface of scripted policies: pure functions of a key and the perceived simulation."""

import abc
from typing import ClassVar, Generic, TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from pigbench.envs.cubes import MAX_CUBES
from pigbench.envs.physics import PhysicsState
from pigbench.envs.scene import Scene
from pigbench.envs.spec import EnvSpec
from pigbench.errors import UserError

Memory = TypeVar("Memory")


class ScriptedPolicy(abc.ABC, Generic[Memory]):
    """A policy whose memory is a pytree. All methods but `check` may be vmapped.

    Raises UserError if the environment has more cubes than the policy can move.

    Attributes:
        episode_rows: the maximum number of rows per episode if the policy ends episodes, else 0.
        most_cubes: the most cubes that it can move.
    """

    episode_rows: ClassVar[int] = 0
    most_cubes: ClassVar[int] = MAX_CUBES

    def __init__(self, spec: EnvSpec, scene: Scene):
        self.check(spec)
        self.spec = spec
        self.scene = scene

    @classmethod
    def check(cls, spec: EnvSpec) -> None:
        """Raise UserError if the environment has more cubes than the policy can move."""
        if spec.num_cubes > cls.most_cubes:
            raise UserError(
                f"{spec.name} has {spec.num_cubes} cubes, and {cls.__name__} moves no more than "
                f"{cls.most_cubes}: choose another policy"
            )

    @abc.abstractmethod
    def reset(self, key: PRNGKeyArray, physics_state: PhysicsState) -> Memory:
        """Begin an episode."""

    @abc.abstractmethod
    def act(
        self, key: PRNGKeyArray, state: Memory, physics_state: PhysicsState
    ) -> Float[Array, "action"]:
        """The action in [-1, 1]."""

    @abc.abstractmethod
    def advance(self, key: PRNGKeyArray, state: Memory, physics_state: PhysicsState) -> Memory:
        """The memory after an action, which led to `physics_state`."""

    @abc.abstractmethod
    def ended(self, state: Memory) -> Bool[Array, ""]:
        """Whether the current action is the last of a sub-task."""

    def finished(self, state: Memory) -> Bool[Array, ""]:
        """Whether the episode ends before the next action; by default, never."""
        return jnp.zeros((), bool)

    def draw_stacking(self, key: PRNGKeyArray) -> Float[Array, ""]:
        """An episode's probability of putting a cube on another."""
        low, high = self.spec.stacking
        return jax.random.uniform(key, minval=low, maxval=high)
