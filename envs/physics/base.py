"""What every physics engine does: advance one simulation by one control step."""

import abc
import warnings
from dataclasses import replace
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from flax import struct

from pigbench.envs.scene import Scene

# Nothing in these scenes ever moves this fast (m/s or rad/s): beyond it a simulation has diverged.
MAX_SPEED = 1e3


@struct.dataclass
class Factors:
    """What a simulation's model is multiplied by; 1 leaves it as it is."""

    friction: jax.Array  # () of all contacts
    mass: jax.Array  # () of the cubes, inertias included


@struct.dataclass
class PhysicsState:
    """A simulation between two control steps; float32, the same for all engines.

    As in OGBench, pinch and contact are those of the last substep's start, 2 ms behind qpos.
    """

    qpos: jax.Array  # (nq,)
    qvel: jax.Array  # (nv,)
    warmstart: jax.Array  # (nv,) accelerations from which the constraint solver starts
    pinch_pos: jax.Array  # (3,) metres
    pinch_yaw: jax.Array  # () radians
    pad_force: jax.Array  # () norm of the external wrench on the right finger's pad
    diverged: jax.Array  # () bool; the rest is the last good state
    overflow: jax.Array  # () bool: it counts as diverged because the engine ran out of room for it
    factors: Factors | None = None  # None where all simulations share the scene's model


def warn_of_overflow(states: PhysicsState) -> None:
    """Warns if simulations of a batch count as diverged for want of room for their contacts."""
    count = int(np.sum(states.overflow))
    if count:
        warnings.warn(
            f"the physics engine had no room for all contacts of {count} simulations, "
            "which count as diverged",
            RuntimeWarning,
            stacklevel=2,
        )


class Physics(abc.ABC):
    """One engine on one scene. `init` and `step` are for a single simulation: vmap them."""

    name: ClassVar[str]

    def __init__(self, scene: Scene):
        self.scene = scene

    def init(self, qpos: jax.Array, qvel: jax.Array | None = None) -> PhysicsState:
        """The state at qpos (nq,) and qvel (nv,), by default at rest."""
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
        self, state: PhysicsState, ctrl: jax.Array, active: jax.Array | bool = True
    ) -> PhysicsState:
        """One control step under `ctrl` (7,): arm joint targets and gripper control.

        A simulation that is not `active`, or has diverged, stays as it is and costs nothing
        where the engine can skip it. A control that is not finite makes it diverge.
        """
        active = jnp.logical_and(active, ~state.diverged)
        # Engines take such a control for zero, and go on.
        sane = jnp.all(jnp.isfinite(ctrl))
        return self._accept(state, self._advance(state, ctrl, active), active, sane)

    @staticmethod
    def _accept(
        old: PhysicsState, new: PhysicsState, active: jax.Array, sane: jax.Array | bool = True
    ) -> PhysicsState:
        sane &= jnp.all(jnp.isfinite(new.qpos)) & jnp.all(jnp.abs(new.qvel) < MAX_SPEED)
        sane &= ~new.overflow
        state = jax.tree.map(lambda a, b: jnp.where(active & sane, b, a), old, new)
        return replace(
            state,
            diverged=old.diverged | (active & ~sane),
            overflow=old.overflow | (active & new.overflow),
        )

    @abc.abstractmethod
    def _forward(self, state: PhysicsState) -> PhysicsState:
        """Fill in what follows from qpos and qvel."""

    @abc.abstractmethod
    def _advance(self, state: PhysicsState, ctrl: jax.Array, active: jax.Array) -> PhysicsState:
        """SUBSTEPS substeps; whatever it returns for a simulation that is not active is dropped."""
