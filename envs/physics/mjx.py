"""The common part of the engines that run inside XLA programs, `mjx-warp` and `mjx-jax`."""

# mujoco's compiled modules have no types.
# pyright: reportAttributeAccessIssue=false

import abc
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Shaped

from pigbench.envs.physics.base import Factors, Physics, PhysicsState
from pigbench.envs.quiet import quiet
from pigbench.envs.scene import SUBSTEPS, Scene

Run = Callable[[PhysicsState, Float[Array, "*batch nu"]], PhysicsState]
"""A function from states and controls to states."""


class MjxPhysics(Physics):
    """MJX, in single precision throughout and on the device."""

    implementation: ClassVar[str]

    def __init__(self, scene: Scene):
        super().__init__(scene)
        with quiet():
            from mujoco import mjx
        self._mjx = mjx
        self._model = self._make_model()
        self._pinch = scene.model.site("pinch").id
        self._pad = scene.model.body("right_pad").id
        self._all = {
            substeps: _over_all_axes(partial(self._simulate, substeps))
            for substeps in (0, SUBSTEPS)
        }

    def _make_model(self) -> Any:
        return self._mjx.put_model(self.scene.model, impl=self.implementation)

    @abc.abstractmethod
    def _make_data(self, simulations: int) -> Any:
        """The `mjx.Data` of one of `simulations` simulations that are stepped together."""

    def _overflow(self, data: Any) -> Bool[Array, ""]:
        """Whether there was no room for a contact or a constraint row."""
        return jnp.zeros((), bool)

    def _forward(self, state: PhysicsState) -> PhysicsState:
        return self._all[0](state, jnp.zeros(self.scene.model.nu))

    def _advance(
        self, state: PhysicsState, ctrl: Float[Array, "nu"], active: Bool[Array, ""]
    ) -> PhysicsState:
        return self._all[SUBSTEPS](state, ctrl)

    def _simulate(
        self, substeps: int, states: PhysicsState, ctrl: Float[Array, "simulation nu"]
    ) -> PhysicsState:
        """Substeps of a batch of simulations; with 0, only a forward pass."""
        with jax.ensure_compile_time_eval():
            data = jax.tree.map(np.asarray, self._make_data(len(ctrl)))
        # Most buffers repeat one number; if computed, they are not constants in the program.
        blank = jax.tree.map(_uniform, data)

        def simulate(state: PhysicsState, ctrl: Float[Array, "nu"]) -> PhysicsState:
            model = self._model if state.factors is None else self._varied(state.factors)
            data = blank.replace(
                qpos=state.qpos, qvel=state.qvel, qacc_warmstart=state.warmstart, ctrl=ctrl
            )
            if not substeps:
                return self._read(state, self._mjx.forward(model, data))
            data = jax.lax.fori_loop(0, substeps, lambda _, data: self._substep(model, data), data)
            return self._read(state, data)

        if len(ctrl) == 1:  # without vmap, loops within a step end as soon as they can
            alone = simulate(*jax.tree.map(lambda x: x[0], (states, ctrl)))
            return jax.tree.map(lambda x: x[None], alone)
        return jax.vmap(simulate)(states, ctrl)

    def _substep(self, model: Any, data: Any) -> Any:
        return self._mjx.step(model, data)

    def _varied(self, factors: Factors) -> Any:
        """The model of one simulation, scaled by its factors."""
        model, scene = self._model, self.scene
        cubes, dofs = scene.cube_bodies, scene.cubes_qvel
        heavier = {
            field: jnp.asarray(getattr(model, field)).at[cubes].multiply(factors.mass)
            for field in ("body_mass", "body_inertia", "body_subtreemass")
        }
        return model.replace(
            pair_friction=model.pair_friction * factors.friction,
            body_invweight0=jnp.asarray(model.body_invweight0).at[cubes].divide(factors.mass),
            dof_invweight0=jnp.asarray(model.dof_invweight0).at[dofs].divide(factors.mass),
            **heavier,
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
            overflow=self._overflow(data),
        )


def _uniform(x: Shaped[np.ndarray, "*shape"]) -> Shaped[Array, "*shape"]:
    if x.size > 1 and np.all(x == x.flat[0]):
        return jnp.full(x.shape, x.flat[0])
    return jnp.asarray(x)


def _over_all_axes(run: Run) -> Run:
    """Turn `run`, on a batch of simulations, into a function of one simulation, to be vmapped.

    All mapped axes are merged into the one that `run` sees, so that it knows the number of
    simulations for which its engine must make room.
    """

    @jax.custom_batching.custom_vmap
    def run_all(states: PhysicsState, ctrl: Float[Array, "*batch nu"]) -> PhysicsState:
        axes = ctrl.shape[:-1]
        rows = jax.tree.map(lambda x: x.reshape(-1, *x.shape[len(axes) :]), (states, ctrl))
        return jax.tree.map(lambda x: x.reshape(*axes, *x.shape[1:]), run(*rows))

    @run_all.def_vmap
    def _(
        size: int, mapped: list[Any], states: PhysicsState, ctrl: Float[Array, "*batch nu"]
    ) -> tuple[PhysicsState, PhysicsState]:
        full = jax.tree.map(
            lambda x, is_mapped: x if is_mapped else jnp.broadcast_to(x, (size, *x.shape)),
            (states, ctrl),
            tuple(mapped),
        )
        return run_all(*full), jax.tree.map(lambda _: True, states)

    return run_all
