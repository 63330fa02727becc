"""The interface of physics engines, which advance one simulation by one control step."""

import abc
import warnings
from dataclasses import replace
from typing import ClassVar

import jax.numpy as jnp
import numpy as np
from flax import struct
from jaxtyping import Array, ArrayLike, Bool, Float

from pigbench.envs import trees
from pigbench.envs.scene import Scene

# Nothing in these scenes moves this fast (m/s or rad/s) unless the simulation has diverged.
MAX_SPEED = 1e3


@struct.dataclass
class Factors:
    """Factors on the parameters of a simulation's model; 1 leaves them unchanged."""

    friction: Float[Array, ""]  # on all contacts
    mass: Float[Array, ""]  # on the cubes' masses and inertias


@struct.dataclass
class PhysicsState:
    """A simulation between two control steps, in float32, the same for all engines.

    As in OGBench, pinch pose and pad force are those at the start of the last substep, 2 ms behind
    qpos.
    """

    qpos: Float[Array, "nq"]
    qvel: Float[Array, "nv"]
    warmstart: Float[Array, "nv"]  # accelerations from which the constraint solver starts
    pinch_pos: Float[Array, "3"]  # metres
    pinch_yaw: Float[Array, ""]  # radians
    pad_force: Float[Array, ""]  # norm of the external wrench on the right finger's pad
    diverged: Bool[Array, ""]  # if true, the rest is the last good state
    overflow: Bool[Array, ""]  # diverged because the engine ran out of room for contacts
    factors: Factors | None = None  # None where all simulations share the scene's model


def warn_of_overflow(states: PhysicsState) -> None:
    """Warn if simulations of a batch count as diverged because contacts did not fit."""
    count = int(np.sum(states.overflow))
    if count:
        warnings.warn(
            f"the physics engine had no room for all contacts of {count} simulations, "
            "which count as diverged",
            RuntimeWarning,
            stacklevel=2,
        )


class Physics(abc.ABC):
    """An engine on a scene. `init` and `step` are for a single simulation: vmap them."""

    name: ClassVar[str]

    batches_at_once = 1
    """Batches of simulations to advance at the same time, each by a thread, to lose no time."""

    def __init__(self, scene: Scene):
        self.scene = scene

    def init(
        self,
        qpos: Float[ArrayLike, "nq"],
        qvel: Float[ArrayLike, "nv"] | None = None,
    ) -> PhysicsState:
        """The state at `qpos` and `qvel`, at rest by default."""
        qvel = jnp.zeros(self.scene.model.nv) if qvel is None else qvel
        zero = jnp.zeros(())
        blank = PhysicsState(
            qpos=jnp.asarray(qpos, jnp.float32),
            qvel=jnp.asarray(qvel, jnp.float32),
            warmstart=jnp.zeros(self.scene.model.nv),
            pinch_pos=jnp.zeros(3),
            pinch_yaw=zero,
            pad_force=zero,
            diverged=jnp.zeros((), bool),
            overflow=jnp.zeros((), bool),
        )
        return self._accept(blank, self._forward(blank), active=jnp.ones((), bool))

    def step(
        self,
        state: PhysicsState,
        ctrl: Float[ArrayLike, "nu"],
        active: Bool[ArrayLike, ""] = True,
    ) -> PhysicsState:
        """One control step under `ctrl`: arm joint targets and gripper control.

        A simulation that is not `active`, or has diverged, does not change, and costs nothing if
        the engine can skip it. A control that is not finite makes a simulation diverge.
        """
        active = jnp.logical_and(active, ~state.diverged)
        # Engines would replace such a control by zero and continue.
        sane = jnp.all(jnp.isfinite(ctrl))
        return self._accept(state, self._advance(state, jnp.asarray(ctrl), active), active, sane)

    @staticmethod
    def _accept(
        old: PhysicsState,
        new: PhysicsState,
        active: Bool[Array, ""],
        sane: Bool[ArrayLike, ""] = True,
    ) -> PhysicsState:
        sane &= jnp.all(jnp.isfinite(new.qpos)) & jnp.all(jnp.abs(new.qvel) < MAX_SPEED)
        sane &= ~new.overflow
        state = trees.where(active & sane, new, old)
        return replace(
            state,
            diverged=old.diverged | (active & ~sane),
            overflow=old.overflow | (active & new.overflow),
        )

    @abc.abstractmethod
    def _forward(self, state: PhysicsState) -> PhysicsState:
        """Compute warmstart, pinch pose, pad force and overflow from qpos and qvel."""

    @abc.abstractmethod
    def _advance(
        self, state: PhysicsState, ctrl: Float[Array, "nu"], active: Bool[Array, ""]
    ) -> PhysicsState:
        """Take SUBSTEPS substeps: every field but `diverged` and `factors` is new.

        The engine's model is that of the scene, with its parameters times `factors` if there are
        any. The results of simulations that are not active are discarded.
        """
