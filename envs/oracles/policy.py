"""The interface of scripted policies: pure functions of a key and the perceived simulation."""

import abc
from typing import ClassVar, Generic, TypeVar

import jax
import jax.numpy as jnp
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from pigbench.envs.physics import PhysicsState
from pigbench.envs.scene import Scene
from pigbench.envs.scripted import Scripted
from pigbench.envs.spec import EnvSpec

Memory = TypeVar("Memory")


class ScriptedPolicy(abc.ABC, Generic[Memory]):
    """A policy whose memory is a pytree. All methods may be vmapped.

    Raises UserError if the environment has more cubes than the policy can move.

    Attributes:
        ability: what it can do.
    """

    ability: ClassVar[Scripted] = Scripted()

    def __init__(self, spec: EnvSpec, scene: Scene):
        self.ability.require(type(self).__name__, spec.name, spec.num_cubes)
        self.spec = spec
        self.scene = scene

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
