"""The engine against a plain loop over MuJoCo in C, to the bit."""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest

from pigbench.envs import physics as engines
from pigbench.envs.physics import PhysicsState
from pigbench.envs.physics.mujoco import MujocoPhysics
from pigbench.envs.scene import SUBSTEPS
from pigbench.errors import UserError

NAME = "cube-double"
BATCH, STEPS = 5, 20


@pytest.fixture(scope="module")
def start(play) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """qpos and qvel (BATCH, ...) of OGBench's play, and its next controls (STEPS, BATCH, 7)."""
    recording = play(NAME, 1500)
    rows = np.array([100, 130, 400, 700, 1000])
    assert recording.contact[rows[:, None] + np.arange(STEPS)].max() > 0.5  # a grasp is in it
    ctrl = np.stack([recording.ctrl[rows + step] for step in range(STEPS)])
    return tuple(np.float32(x) for x in (recording.qpos[rows], recording.qvel[rows], ctrl))


def rollout(engine: MujocoPhysics, start, active=True) -> tuple[PhysicsState, PhysicsState]:
    """First and last states of the batch."""
    qpos, qvel, ctrl = start

    @jax.jit
    def run(qpos, qvel, ctrl):
        first = jax.vmap(engine.init)(qpos, qvel)
        step = jax.vmap(lambda state, u: engine.step(state, u, active))
        return first, jax.lax.scan(lambda state, u: (step(state, u), None), first, ctrl)[0]

    return run(qpos, qvel, ctrl)


def row(tree, index: int):
    return jax.tree.map(lambda x: x[index], tree)


def assert_same_bytes(one, other) -> None:
    for path, leaf in jax.tree.leaves_with_path(one):
        match = dict(jax.tree.leaves_with_path(other))[path]
        assert np.asarray(leaf).tobytes() == np.asarray(match).tobytes(), jax.tree_util.keystr(path)


def loop_in_c(model: mujoco.MjModel, qpos, qvel, ctrl) -> PhysicsState:
    """One simulation with MjData, its state rounded to float32 after every control step."""
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = qpos, qvel
    mujoco.mj_forward(model, data)
    for u in ctrl:
        for field in ("qpos", "qvel", "qacc_warmstart"):
            getattr(data, field)[:] = np.float32(getattr(data, field))
        data.ctrl[:] = u
        mujoco.mj_step(model, data, nstep=SUBSTEPS)
    pinch = data.site("pinch")
    wrench = data.body("right_pad").cfrc_ext
    return PhysicsState(
        qpos=np.float32(data.qpos),
        qvel=np.float32(data.qvel),
        warmstart=np.float32(data.qacc_warmstart),
        pinch_pos=np.float32(pinch.xpos),
        pinch_yaw=np.float32(np.arctan2(pinch.xmat[3], pinch.xmat[0])),
        pad_force=np.float32(np.sqrt((wrench**2).sum())),
        diverged=np.array(False),
        overflow=np.array(False),
    )


def test_steps_as_a_loop_in_c(scene, start):
    engine = MujocoPhysics(scene(2))
    _, final = rollout(engine, start)
    qpos, qvel, ctrl = start
    for i in range(BATCH):
        expected = loop_in_c(scene(2).model, qpos[i], qvel[i], ctrl[:, i])
        # The norm of the force may be summed in another order.
        np.testing.assert_allclose(final.pad_force[i], expected.pad_force, rtol=1e-6)
        assert_same_bytes(row(final, i).replace(pad_force=0.0), expected.replace(pad_force=0.0))
    assert final.pad_force.max() > 1.0


def test_init_computes_what_follows_from_the_state(scene, start):
    qpos, qvel, _ = start
    first, _ = rollout(MujocoPhysics(scene(2)), start)
    assert np.asarray(first.qpos).tobytes() == qpos.tobytes()
    assert np.asarray(first.qvel).tobytes() == qvel.tobytes()
    for i in range(BATCH):
        expected = loop_in_c(scene(2).model, qpos[i], qvel[i], ctrl=())
        np.testing.assert_allclose(first.pinch_pos[i], expected.pinch_pos, atol=1e-7)
        np.testing.assert_allclose(first.pad_force[i], expected.pad_force, rtol=1e-6)


def test_by_default_at_rest(scene):
    state = MujocoPhysics(scene(2)).init(scene(2).home_qpos)
    assert not state.qvel.any()
    assert not state.diverged


def test_threads_do_not_matter(scene, start):
    assert_same_bytes(*(rollout(MujocoPhysics(scene(2), threads), start)[1] for threads in (1, 2)))


def test_the_batch_does_not_matter(scene, start):
    engine = MujocoPhysics(scene(2))
    together = rollout(engine, start)[1]
    qpos, qvel, ctrl = start
    for i in range(BATCH):
        alone = rollout(engine, (qpos[i : i + 1], qvel[i : i + 1], ctrl[:, i : i + 1]))[1]
        assert_same_bytes(row(together, i), row(alone, 0))


def test_nested_vmap(scene, start):
    engine = MujocoPhysics(scene(2))
    qpos, qvel, ctrl = (x[..., :4, :] for x in start)
    states = jax.vmap(engine.init)(qpos, qvel)
    flat = jax.vmap(engine.step)(states, ctrl[0])
    grid = jax.tree.map(lambda x: x.reshape(2, 2, *x.shape[1:]), (states, ctrl[0]))
    nested = jax.jit(jax.vmap(jax.vmap(engine.step)))(*grid)
    assert_same_bytes(jax.tree.map(lambda x: x.reshape(4, *x.shape[2:]), nested), flat)


def test_one_control_for_all(scene, start):
    """A control that is not batched, inside vmap, is each simulation's."""
    engine = MujocoPhysics(scene(2))
    qpos, qvel, ctrl = start
    states = jax.vmap(engine.init)(qpos, qvel)
    shared = jax.vmap(engine.step, in_axes=(0, None))(states, ctrl[0, 0])
    each = jax.vmap(engine.step)(states, jnp.broadcast_to(ctrl[0, 0], (BATCH, 7)))
    assert_same_bytes(shared, each)


def test_inactive_simulations_stay_as_they_are(scene, start):
    engine = MujocoPhysics(scene(2))
    qpos, qvel, ctrl = start
    states = jax.vmap(engine.init)(qpos, qvel)
    active = np.array([True, False, True, False, False])
    stepped = jax.vmap(engine.step)(states, ctrl[0], active)
    full = jax.vmap(engine.step)(states, ctrl[0])
    for i in range(BATCH):
        assert_same_bytes(row(stepped, i), row(full if active[i] else states, i))
    none = jax.vmap(engine.step)(states, ctrl[0], np.zeros(BATCH, bool))
    assert_same_bytes(none, states)


def spoil(states: PhysicsState, what: str, index: int) -> PhysicsState:
    match what:
        case "fast cube":
            return states.replace(qvel=states.qvel.at[index, -6].set(1e6))
        case "fast arm":
            return states.replace(qvel=states.qvel.at[index, 0].set(1e6))
        case "lost joint":
            return states.replace(qpos=states.qpos.at[index, 2].set(jnp.nan))
        case "lost speed":
            return states.replace(qvel=states.qvel.at[index, 2].set(jnp.inf))
        case _:
            raise ValueError(what)


SPOILED = ("fast cube", "fast arm", "lost joint", "lost speed")


@pytest.mark.parametrize("what", SPOILED)
def test_divergence_is_flagged_and_neighbours_do_not_notice(scene, start, what):
    engine = MujocoPhysics(scene(2))
    qpos, qvel, ctrl = start
    states = jax.vmap(engine.init)(qpos, qvel)
    spoiled = spoil(states, what, index=2)
    step = jax.jit(jax.vmap(engine.step))
    well, ill = step(states, ctrl[0]), step(spoiled, ctrl[0])
    assert list(ill.diverged) == [False, False, True, False, False]
    for i in (0, 1, 3, 4):
        assert_same_bytes(row(ill, i), row(well, i))
    # It keeps the last state and stays flagged.
    assert_same_bytes(row(ill, 2).replace(diverged=False), row(spoiled, 2).replace(diverged=False))
    again = step(ill, ctrl[1])
    assert_same_bytes(row(again, 2), row(ill, 2))
    for i in (0, 1, 3, 4):
        assert_same_bytes(row(again, i), row(step(well, ctrl[1]), i))


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_divergence_at_the_start(scene, start, bad):
    qpos, qvel, _ = start
    broken = qpos.copy()
    broken[1, 3] = bad
    states = jax.vmap(MujocoPhysics(scene(2)).init)(broken, qvel)
    assert list(states.diverged) == [False, True, False, False, False]


def test_a_nan_control_is_flagged(scene, start):
    """A policy whose numbers have blown up must not pass for one that stands still."""
    engine = MujocoPhysics(scene(2))
    qpos, qvel, ctrl = start
    states = jax.vmap(engine.init)(qpos, qvel)
    broken = ctrl[0].copy()
    broken[3, 1] = np.nan
    stepped = jax.vmap(engine.step)(states, broken)
    assert list(stepped.diverged) == [False, False, False, True, False]


def test_may_be_called_from_several_threads(scene, start):
    engine = MujocoPhysics(scene(2))
    qpos, qvel, ctrl = (np.repeat(x, 8, axis=-2) for x in start)
    states = jax.vmap(engine.init)(qpos, qvel)
    step = jax.jit(jax.vmap(engine.step))
    ctrl = ctrl[:8]
    expected = [step(states, u) for u in ctrl]
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(lambda u: jax.block_until_ready(step(states, u)), ctrl))
    assert_same_bytes(found, expected)


class Slowed(MujocoPhysics):
    """An engine with a state of its own."""

    def __init__(self, scene, kept: float):
        super().__init__(scene)
        self.kept = np.float32(kept)

    def _run_batch(self, *args):
        state = super()._run_batch(*args)
        return state.replace(qvel=state.qvel * self.kept)


def test_an_engine_whose_model_or_state_differs_is_another(scene, start):
    """Programs find their engine by what it computes, not by which object it is."""
    plain, heavy = MujocoPhysics(scene(2)), MujocoPhysics(scene(2))
    heavy._model.opt.gravity[2] *= 2
    expected = rollout(plain, start)[1]
    assert_same_bytes(rollout(MujocoPhysics(scene(2)), start)[1], expected)
    others = heavy, Slowed(scene(2), 0.9), Slowed(scene(2), 0.5)
    found = [expected, *(rollout(engine, start)[1] for engine in others)]
    assert len({np.asarray(one.qvel).tobytes() for one in found}) == len(found)


def test_engines_by_name(scene):
    assert engines.make("mujoco", scene(2)).name == engines.default_engine() == "mujoco"
    with pytest.raises(UserError, match=r"'mujco': did you mean 'mujoco'"):
        engines.make("mujco", scene(2))


def test_what_diverges_writes_no_log(tmp_path):
    """MuJoCo by itself writes MUJOCO_LOG.TXT where the user is; in a process that is there."""
    code = (
        "import jax.numpy as jnp\n"
        "from pigbench import envs\n"
        "physics = envs.make('cube-single').physics\n"
        "model = physics.scene.model\n"
        "state = physics.init(jnp.asarray(model.qpos0), jnp.full(model.nv, 1e30))\n"
        "state = physics.step(state, jnp.zeros(model.nu))\n"
        "assert state.diverged\n"
    )
    done = subprocess.run(
        [sys.executable, "-P", "-c", code], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert not list(tmp_path.iterdir())
