"""MuJoCo's XLA engines: `mjx-warp` for NVIDIA GPUs, `mjx-jax` for TPUs and other accelerators."""

# mujoco's compiled modules carry no types.
# pyright: reportAttributeAccessIssue=false

import abc
import importlib.util
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from pigbench.envs.physics.base import Physics, PhysicsState
from pigbench.envs.quiet import quiet
from pigbench.envs.scene import SUBSTEPS, Scene
from pigbench.errors import UserError

Run = Callable[[PhysicsState, jax.Array], PhysicsState]
"""From states and controls to states."""

# Room for contacts of one simulation: those of a grasp, and those that a cube has with the floor, a
# wall and its neighbours. Six episodes of OGBench's play with two cubes have 24 at most, of 56.
_GRASP_CONTACTS, _CUBE_CONTACTS = 32, 12
_ROWS = 3  # constraint rows of a contact, and the most of an equality

# Of MJX's solver in JAX, and of its line search, which looks at three points in each. C needs 13 at
# most in OGBench's play, and 31 points; in single precision some go on to the default's 100.
_ITERATIONS = 20


class MjxPhysics(Physics):
    """Single precision throughout, on the device."""

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
        """The `mjx.Data` of one simulation among so many that are stepped together."""

    def _overflow(self, data: Any) -> jax.Array:
        """Whether there was no room for a contact or a constraint row, () bool."""
        return jnp.zeros((), bool)

    def _forward(self, state: PhysicsState) -> PhysicsState:
        return self._all[0](state, jnp.zeros(self.scene.model.nu))

    def _advance(self, state: PhysicsState, ctrl: jax.Array, active: jax.Array) -> PhysicsState:
        return self._all[SUBSTEPS](state, ctrl)

    def _simulate(self, substeps: int, states: PhysicsState, ctrl: jax.Array) -> PhysicsState:
        """So many substeps of a batch, arrays (simulations, ...); none: what follows from it."""
        with jax.ensure_compile_time_eval():
            data = jax.tree.map(np.asarray, self._make_data(len(ctrl)))
        # Buffers are of one number each: computed, they are no constants in the program.
        blank = jax.tree.map(_uniform, data)

        def simulate(state: PhysicsState, ctrl: jax.Array) -> PhysicsState:
            data = blank.replace(
                qpos=state.qpos, qvel=state.qvel, qacc_warmstart=state.warmstart, ctrl=ctrl
            )
            if not substeps:
                return self._read(state, self._mjx.forward(self._model, data))
            data = jax.lax.fori_loop(0, substeps, lambda _, data: self._substep(data), data)
            return self._read(state, data)

        if len(ctrl) == 1:  # unmapped, loops within a step end when they can, not all together
            alone = simulate(*jax.tree.map(lambda x: x[0], (states, ctrl)))
            return jax.tree.map(lambda x: x[None], alone)
        return jax.vmap(simulate)(states, ctrl)

    def _substep(self, data: Any) -> Any:
        return self._mjx.step(self._model, data)

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


class MjxJax(MjxPhysics):
    """MJX in pure JAX. On a CPU only for a few environments: it compiles long and runs slowly."""

    name = "mjx-jax"
    implementation = "jax"

    def __init__(self, scene: Scene):
        super().__init__(scene)
        _mend_line_search()

    def _make_model(self) -> Any:
        limits = {"opt.iterations": _ITERATIONS, "opt.ls_iterations": _ITERATIONS}
        return super()._make_model().tree_replace(limits)

    def _make_data(self, simulations: int) -> Any:
        return self._mjx.make_data(self.scene.model, impl=self.implementation)

    def _substep(self, data: Any) -> Any:
        """MJX takes an actuator at its force limit for one that still damps; C does not."""
        data = self._mjx.forward(self._model, data)
        low, high = self.scene.model.actuator_forcerange.T
        at_limit = (data.actuator_force <= low) | (data.actuator_force >= high)
        gains = jnp.where(at_limit[:, None], 0.0, self._model.actuator_biasprm)
        return self._mjx.implicit(self._model.replace(actuator_biasprm=gains), data)


class MjxWarp(MjxPhysics):
    """MJX over NVIDIA Warp. Raises UserError where the package's `warp` extra is not installed."""

    name = "mjx-warp"
    implementation = "warp"

    def __init__(self, scene: Scene):
        if importlib.util.find_spec("warp") is None:
            raise UserError("engine mjx-warp needs NVIDIA Warp: pip install 'pigbench[warp]'")
        super().__init__(scene)
        from mujoco.mjx.third_party.mujoco_warp import OverflowType

        self._no_overflow = OverflowType.ITERATIONS  # a solver that stops early, as in C

    def _make_model(self) -> Any:
        return super()._make_model().tree_replace({"opt._impl.warn_overflow": 0})

    def _make_data(self, simulations: int) -> Any:
        model = self.scene.model
        contacts = _GRASP_CONTACTS + _CUBE_CONTACTS * self.scene.num_cubes
        return self._mjx.make_data(
            model,
            impl=self.implementation,
            naconmax=simulations * contacts,
            njmax=_ROWS * (contacts + model.neq) + int(np.sum(model.jnt_limited)),
        )

    def _overflow(self, data: Any) -> jax.Array:
        return (data._impl.overflow & ~int(self._no_overflow)) != 0


@cache
def _mend_line_search() -> None:
    """Keep MJX's solver from stopping early in single precision.

    Its line search expands the square of a contact's tangential velocity in the step length. Where
    a contact sticks, the sum can round to less than zero, whose root is no number, and every
    candidate is refused. The constant term is enlarged by what rounding may take away.
    """
    from mujoco.mjx._src import solver

    evaluate = solver._LSPoint.create
    rounding = 16 * float(jnp.finfo(jnp.float32).eps)

    def evaluate_safely(*arguments: Any) -> Any:
        *others, squares, v0, uv, vv = arguments
        return evaluate(*others, squares * (1 + rounding), v0, uv, vv)

    solver._LSPoint.create = evaluate_safely


def _uniform(x: np.ndarray) -> jax.Array:
    if x.size > 1 and np.all(x == x.flat[0]):
        return jnp.full(x.shape, x.flat[0])
    return jnp.asarray(x)


def _over_all_axes(run: Run) -> Run:
    """`run`, of arrays (simulations, ...), as a function of one simulation that is to be vmapped.

    All axes that are mapped over it become the one that `run` sees, so that it knows how many
    simulations there are, for which its engine must make room.
    """

    @jax.custom_batching.custom_vmap
    def run_all(states: PhysicsState, ctrl: jax.Array) -> PhysicsState:
        axes = ctrl.shape[:-1]
        rows = jax.tree.map(lambda x: x.reshape(-1, *x.shape[len(axes) :]), (states, ctrl))
        return jax.tree.map(lambda x: x.reshape(*axes, *x.shape[1:]), run(*rows))

    @run_all.def_vmap
    def _(size: int, mapped: Any, states: PhysicsState, ctrl: jax.Array) -> tuple[Any, Any]:
        full = jax.tree.map(
            lambda x, is_mapped: x if is_mapped else jnp.broadcast_to(x, (size, *x.shape)),
            (states, ctrl),
            tuple(mapped),
        )
        return run_all(*full), jax.tree.map(lambda _: True, states)

    return run_all
