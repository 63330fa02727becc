"""MuJoCo's XLA engines: `mjx-warp` for NVIDIA GPUs, `mjx-jax` for TPUs and other accelerators."""

from dataclasses import replace
from functools import partial
from typing import Any, ClassVar

import jax
import jax.numpy as jnp

from pigbench.envs.physics.base import Physics, PhysicsState
from pigbench.envs.scene import SUBSTEPS, Scene


class MjxPhysics(Physics):
    """Single precision throughout, on the device."""

    implementation: ClassVar[str]

    def __init__(self, scene: Scene):
        super().__init__(scene)
        from mujoco import mjx

        self._mjx = mjx
        self._model = mjx.put_model(scene.model, impl=self.implementation)
        self._pinch = scene.model.site("pinch").id
        self._pad = scene.model.body("right_pad").id

    def _forward(self, state: PhysicsState) -> PhysicsState:
        ctrl = jnp.zeros(self.scene.model.nu)
        return self._read(state, self._mjx.forward(self._model, self._load(state, ctrl)))

    def _advance(self, state: PhysicsState, ctrl: jax.Array, active: jax.Array) -> PhysicsState:
        step = partial(self._mjx.step, self._model)
        data = jax.lax.fori_loop(0, SUBSTEPS, lambda _, data: step(data), self._load(state, ctrl))
        return self._read(state, data)

    def _load(self, state: PhysicsState, ctrl: jax.Array) -> Any:
        data = self._mjx.make_data(self.scene.model, impl=self.implementation)
        return data.replace(
            qpos=state.qpos, qvel=state.qvel, qacc_warmstart=state.warmstart, ctrl=ctrl
        )

    def _read(self, state: PhysicsState, data: Any) -> PhysicsState:
        rotation = data.site_xmat[self._pinch].reshape(3, 3)
        return replace(
            state,
            qpos=data.qpos,
            qvel=data.qvel,
            warmstart=data.qacc_warmstart,
            pinch_pos=data.site_xpos[self._pinch],
            pinch_yaw=jnp.arctan2(rotation[1, 0], rotation[0, 0]),
            pad_force=jnp.linalg.norm(data._impl.cfrc_ext[self._pad]),
        )


class MjxJax(MjxPhysics):
    """MJX in pure JAX. On a CPU only for a few environments: it compiles long and runs slowly."""

    name = "mjx-jax"
    implementation = "jax"


class MjxWarp(MjxPhysics):
    """MJX over NVIDIA Warp; needs the package's `warp` extra."""

    name = "mjx-warp"
    implementation = "warp"
