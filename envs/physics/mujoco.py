"""MuJoCo in C on all cores, called by compiled programs."""

# mujoco's compiled modules have no types.
# pyright: reportAttributeAccessIssue=false

import copy
import hashlib
import itertools
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from jaxtyping import Array, Bool, Float, Int
from mujoco.batch import Batch, SimulationError

from pigbench.envs.physics.base import Factors, Physics, PhysicsState
from pigbench.envs.scene import SUBSTEPS, Scene
from pigbench.support import cores
from pigbench.support.host_calls import host_call

_MOST_BATCHES = 8  # at once: each has a thread per core, and memory

_numbers = itertools.count(1)


@dataclass
class _Simulations:
    """A batch of simulations."""

    batch: Batch
    factors: bytes = b""  # which its models have
    busy: bool = False  # one thread at a time works in it


class MujocoPhysics(Physics):
    """MuJoCo in C: double precision within a control step, float32 between control steps."""

    name = "mujoco"

    def __init__(self, scene: Scene, threads: int | None = None):
        super().__init__(scene)
        _keep_no_log()
        self._model = copy.copy(scene.model)
        # Divergence must be detected; MuJoCo would reset the simulation by itself.
        self._model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
        self._threads = threads or cores.available()
        # Engines on equal models are one; those of other classes may have a state of their own.
        self._number = 0 if type(self) is MujocoPhysics else next(_numbers)
        self._made: dict[tuple[int, bool], list[_Simulations]] = {}
        self._lock = threading.Lock()  # of what is made and busy
        self.batches_at_once = min(self._threads, _MOST_BATCHES)

    def _forward(self, state: PhysicsState) -> PhysicsState:
        ctrl = jnp.zeros(self.scene.model.nu)
        return self._call(0, state, ctrl, jnp.ones((), bool))

    def _advance(
        self, state: PhysicsState, ctrl: Float[Array, "nu"], active: Bool[Array, ""]
    ) -> PhysicsState:
        return self._call(SUBSTEPS, state, ctrl, active)

    def _call(
        self,
        substeps: int,
        state: PhysicsState,
        ctrl: Float[Array, "nu"],
        active: Bool[Array, ""],
    ) -> PhysicsState:
        return host_call(
            f"{substeps} {self._identity()}",
            partial(self._run, substeps),
            jax.tree.map(lambda x: jax.ShapeDtypeStruct(x.shape, x.dtype), state),
            state,
            ctrl,
            active,
        )

    def _identity(self) -> str:
        """What the engine computes: the model, and which class's engine it is."""
        model = np.empty(mujoco.mj_sizeModel(self._model), np.uint8)
        mujoco.mj_saveModel(self._model, None, model)
        digest = hashlib.sha256(model.tobytes()).hexdigest()
        return f"{type(self).__qualname__} {self._number} {self._threads} {digest}"

    def _run(
        self,
        substeps: int,
        state: PhysicsState,
        ctrl: Float[Array | np.ndarray, "*batch nu"],
        active: Bool[Array | np.ndarray, "*batch"],
    ) -> PhysicsState:
        """What programs call, in NumPy; leading dimensions are simulations of one batch."""
        return self._run_batch(substeps, *jax.tree.map(np.asarray, (state, ctrl, active)))

    def _run_batch(
        self,
        substeps: int,
        state: PhysicsState,
        ctrl: Float[np.ndarray, "*batch nu"],
        active: Bool[np.ndarray, "*batch"],
    ) -> PhysicsState:
        with self._batch(active.size, state.factors) as batch:
            batch.qpos[:] = state.qpos.reshape(batch.nsim, -1)
            batch.qvel[:] = state.qvel.reshape(batch.nsim, -1)
            batch.qacc_warmstart[:] = state.warmstart.reshape(batch.nsim, -1)
            batch.ctrl[:] = ctrl.reshape(batch.nsim, -1)
            ids = np.flatnonzero(active)
            failed = np.zeros(0, int)
            try:
                if substeps:
                    batch.step(ids, nstep=substeps)
                else:
                    batch.forward(ids)
            except SimulationError as error:
                failed = error.ids
            return _after(batch, state, failed)

    @contextmanager
    def _batch(self, nsim: int, factors: Factors | None) -> Iterator[Batch]:
        """A batch for this thread alone, each of whose simulations has a model of its `factors`."""
        wanted = b"".join(x.tobytes() for x in jax.tree.leaves(factors))
        with self._lock:
            simulations = self._idle(nsim, wanted)
            simulations.busy = True
        try:
            if factors is not None and simulations.factors != wanted:
                _vary(simulations.batch, self.scene, factors)
                simulations.factors = wanted
            yield simulations.batch
        finally:
            simulations.busy = False

    def _idle(self, nsim: int, factors: bytes) -> _Simulations:
        """Simulations that are not busy, which have these factors if some do."""
        made = self._made.setdefault((nsim, bool(factors)), [])
        idle = sorted((one for one in made if not one.busy), key=lambda x: x.factors != factors)
        if idle and (idle[0].factors == factors or len(made) >= self.batches_at_once):
            return idle[0]
        batch = Batch(self._model, nsim, self._threads)
        for field in ("site_xpos", "site_xmat", "cfrc_ext"):
            batch.bind(field)
        made.append(_Simulations(batch))
        return made[-1]


def _after(batch: Batch, before: PhysicsState, failed: Int[np.ndarray, "failed"]) -> PhysicsState:
    """The batch's states, of the shapes of those `before`; a failed simulation's qpos is NaN."""
    qpos = batch.qpos.astype(np.float32)
    qpos[failed] = np.nan
    pinch = batch.site("pinch")
    rotation = pinch.xmat
    wrench = batch.body("right_pad").cfrc_ext
    new = {
        "qpos": qpos,
        "qvel": batch.qvel,
        "warmstart": batch.qacc_warmstart,
        "pinch_pos": pinch.xpos,
        "pinch_yaw": np.arctan2(rotation[:, 3], rotation[:, 0]),
        "pad_force": np.linalg.norm(wrench, axis=-1),
    }
    shaped = {
        name: np.reshape(x, np.shape(getattr(before, name))).astype(np.float32)
        for name, x in new.items()
    }
    return replace(before, **shaped)


def _vary(batch: Batch, scene: Scene, factors: Factors) -> None:
    """Give each simulation of the batch its own model."""
    cubes, friction, mass = scene.cube_bodies, factors.friction.ravel(), factors.mass.ravel()
    wanted = {"pair_friction": friction[:, None, None] * batch.model.pair_friction}
    for field in ("body_mass", "body_inertia"):
        usual = getattr(batch.model, field)
        wanted[field] = np.tile(usual, (batch.nsim, *[1] * usual.ndim))
        wanted[field][:, cubes] *= mass.reshape(-1, *[1] * usual.ndim)
    stale = [field for field in wanted if not np.array_equal(batch.expand(field), wanted[field])]
    for field in stale:
        batch.expand(field)[:] = wanted[field]
    if "body_mass" in stale:
        batch.set_const()


def _keep_no_log() -> None:
    """Keep MuJoCo from writing warnings to MUJOCO_LOG.TXT in the user's working directory.

    It warns of simulations that diverge, which their states record.
    """
    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(lambda _: None)
