"""What a scripted policy does: pure functions of a key and the simulation's state, as it seems."""

import abc
from typing import ClassVar, Generic, TypeVar

import jax
import jax.numpy as jnp

from pigbench.envs.physics import PhysicsState
from pigbench.envs.scene import Scene

Memory = TypeVar("Memory")


class Policy(abc.ABC, Generic[Memory]):
    """A policy that remembers a pytree between control steps. All methods may be vmapped.

    Attributes:
        episode_rows: the most rows of an episode, of a policy that ends its own; 0 if none does.
    """

    episode_rows: ClassVar[int] = 0

    def __init__(self, scene: Scene):
        self.scene = scene

    @abc.abstractmethod
    def reset(self, key: jax.Array, physics_state: PhysicsState) -> Memory:
        """Begin an episode."""

    @abc.abstractmethod
    def act(self, key: jax.Array, state: Memory, physics_state: PhysicsState) -> jax.Array:
        """The action (5,) in [-1, 1]."""

    @abc.abstractmethod
    def advance(self, key: jax.Array, state: Memory, physics_state: PhysicsState) -> Memory:
        """Take note of the simulation's state after the action."""

    @abc.abstractmethod
    def ended(self, state: Memory) -> jax.Array:
        """Whether the present action is a sub-task's last, () bool."""

    def finished(self, state: Memory) -> jax.Array:
        """Whether the episode is over before the next action, () bool; of most it never is."""
        return jnp.zeros((), bool)
