"""MJX over Warp and in JAX, on the CPU, against MuJoCo in C in double precision.

Both compute in single precision, which is good to about 1e-7 of a metre or radian in free space.
Stiff constraints multiply that: the links of the fingers, which weigh next to nothing, can come out
a milliradian elsewhere after a control step, and a gripped cube ten micrometres. The bounds are a
few times what was seen.
"""

import importlib.util
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest

from pigbench import envs
from pigbench.envs import CubeEnv, control
from pigbench.envs import physics as engines
from pigbench.envs.environment import SUCCESS_DISTANCE
from pigbench.envs.observation import PAD_FORCE_SCALE, cube_poses
from pigbench.envs.oracles import PlayPolicy
from pigbench.envs.oracles.play import PlayState
from pigbench.envs.physics import PhysicsState, mjx
from pigbench.envs.physics.mjx import MjxWarp
from pigbench.envs.scene import SUBSTEPS
from pigbench.errors import UserError

NAME = "cube-double"
# Engine -> the profile it is tested on. In JAX every contact that might be costs compilation.
PROFILES = {"mujoco": "exact", "mjx-warp": "exact", "mjx-jax": "fast"}
ENGINES = [
    pytest.param(name, marks=pytest.mark.slow) if name == "mjx-jax" else name for name in PROFILES
]

# Situation -> bounds after one step: arm (radians), cubes (metres), contact number.
BOUNDS = {
    "free": (2e-6, 2e-6, 1e-6),
    "grasp": (1e-5, 1e-4, 2e-2),
    "stack": (2e-6, 2e-5, 1e-6),
}
FINGERS = 4e-3  # radians


@pytest.fixture(scope="module")
def start(play):
    """A state and control of OGBench's play in each situation: qpos, qvel (3, ...), ctrl (3, 7)."""
    recording = play(NAME, 1500)
    gripped, free = recording.contact > 0.5, recording.contact == 0
    carried = recording.qpos[:, [16, 23]].max(axis=1) > 0.05
    rows = [
        np.flatnonzero(free & ~recording.stacked)[50],
        np.flatnonzero(gripped & carried & ~recording.stacked)[10],
        np.flatnonzero(free & recording.stacked)[10],
    ]
    columns = (recording.qpos, recording.qvel, recording.ctrl)
    return tuple(np.float32(column[rows]) for column in columns)


class Simulator(NamedTuple):
    """An engine's functions for one simulation, compiled once."""

    env: CubeEnv
    init: Callable[..., PhysicsState]
    step: Callable[..., PhysicsState]


@pytest.fixture(scope="module")
def simulator() -> Callable[[str], Simulator]:
    @cache
    def make(engine: str) -> Simulator:
        env = envs.make(NAME, engine=engine, profile=PROFILES[engine])
        return Simulator(env, jax.jit(env.physics.init), jax.jit(env.physics.step))

    return make


def step_in_c(model: mujoco.MjModel, qpos, qvel, ctrl) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.ctrl[:] = qpos, qvel, 0
    mujoco.mj_forward(model, data)
    data.ctrl[:] = ctrl
    mujoco.mj_step(model, data, nstep=SUBSTEPS)
    return data


@pytest.mark.parametrize("engine", ENGINES)
def test_a_control_step_is_that_of_mujoco_in_c(simulator, start, engine):
    env, init, step = simulator(engine)
    for (situation, bounds), qpos, qvel, ctrl in zip(BOUNDS.items(), *start, strict=True):
        after = step(init(qpos, qvel), ctrl)
        assert not after.diverged
        data = step_in_c(env.scene.model, qpos, qvel, ctrl)
        apart = np.abs(after.qpos - data.qpos)
        force = np.linalg.norm(data.body("right_pad").cfrc_ext)
        errors = (
            apart[env.scene.arm].max(),
            apart[env.scene.cubes_qpos].reshape(2, 7)[:, :3].max(),
            abs(after.pad_force - force) * PAD_FORCE_SCALE,
        )
        print(f"{engine}, {situation}:", *(f"{error:.1e}" for error in errors))
        np.testing.assert_array_less(errors, bounds, err_msg=situation)
        assert apart[env.scene.gripper].max() < FINGERS
        np.testing.assert_allclose(after.pinch_pos, data.site("pinch").xpos, atol=bounds[0])
        assert (force > 10) == (situation == "grasp")


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_picks_and_places_a_cube(simulator, engine):
    """The scripted policy's plan, of fewer than 200 control steps, brings the cube there."""
    env, init, step = simulator(engine)
    policy = PlayPolicy(env.scene)
    key = jax.random.key(3)
    reference = simulator("mujoco").env
    begin = jax.jit(reference.random_scene)(key)
    memory = jax.jit(policy.reset)(key, begin)

    @jax.jit
    def controls(memory: PlayState, state: PhysicsState) -> jax.Array:
        return control.servo_targets(env.scene, state, policy.act(key, memory, state))

    state = init(begin.qpos, begin.qvel)
    assert 50 < memory.plan.length < 200
    for time in range(memory.plan.length):
        state = step(state, controls(memory.replace(time=time), state))
    assert not state.diverged
    far, near = (
        np.linalg.norm(cube_poses(env.scene, one)[0][memory.target.cube] - memory.target.pos)
        for one in (begin, state)
    )
    assert far > 2 * SUCCESS_DISTANCE
    assert near < SUCCESS_DISTANCE / 2


@pytest.fixture(scope="module")
def warp(scene, start):
    """The engine on two cubes, and its states of a batch of three."""
    physics = MjxWarp(scene(2))
    return physics, jax.jit(jax.vmap(physics.init))(*start[:2])


def test_vmaps_within_vmaps_are_one_batch(warp, start):
    physics, states = warp
    ctrl = start[2]
    flat = jax.jit(jax.vmap(physics.step))(states, ctrl)
    nested = jax.jit(jax.vmap(jax.vmap(physics.step)))(
        *jax.tree.map(lambda x: x[:, None], (states, ctrl))
    )
    for one, other in zip(jax.tree.leaves(flat), jax.tree.leaves(nested), strict=True):
        np.testing.assert_allclose(np.squeeze(other, axis=1), one, atol=1e-5)


def test_a_simulation_that_diverges_is_flagged_alone(warp, start):
    physics, states = warp
    broken = start[2].copy()
    broken[1, 3] = np.nan
    after = jax.jit(jax.vmap(physics.step))(states, broken)
    assert list(after.diverged) == [False, True, False]
    assert not after.overflow.any()
    np.testing.assert_array_equal(after.qpos[1], states.qpos[1])


@pytest.mark.parametrize("room", [("_GRASP_CONTACTS", "_CUBE_CONTACTS"), ("_ROWS",)])
def test_want_of_room_for_contacts_or_rows_is_reported(monkeypatch, capfd, scene, start, room):
    for name in room:
        monkeypatch.setattr(mjx, name, 0 if name == "_ROWS" else 1)
    physics = MjxWarp(scene(2))
    states = jax.jit(jax.vmap(physics.init))(*start[:2])
    after = jax.jit(jax.vmap(physics.step))(states, start[2])
    assert after.overflow.any()
    np.testing.assert_array_equal(after.diverged, after.overflow)
    assert "overflow" not in capfd.readouterr().out  # the flag says it, Warp need not
    with pytest.warns(RuntimeWarning, match=f"contacts of {after.overflow.sum()} simulations"):
        engines.warn_of_overflow(after)


def test_room_grows_with_cubes_and_simulations(scene):
    def sizes(cubes: int, simulations: int) -> tuple[int, int]:
        data = MjxWarp(scene(cubes))._make_data(simulations)
        return data._impl.naconmax, data._impl.njmax

    contacts, rows = sizes(1, 1)
    assert sizes(1, 64) == (64 * contacts, rows)
    assert sizes(4, 1)[0] > contacts
    assert sizes(4, 1)[1] > rows


def test_warp_must_be_installed(monkeypatch, scene):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(UserError, match=r"pip install 'pigbench\[warp\]'"):
        MjxWarp(scene(1))


@pytest.mark.parametrize(
    ("platform", "has_warp", "expected"),
    [
        ("cpu", True, "mujoco"),
        ("gpu", True, "mjx-warp"),
        ("gpu", False, "mjx-jax"),
        ("tpu", True, "mjx-jax"),
    ],
)
def test_the_engine_follows_from_the_device(monkeypatch, platform, has_warp, expected):
    monkeypatch.setattr(jax, "default_backend", lambda: platform)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: object() if has_warp else None)
    assert engines.default_engine() == expected


def test_states_of_one_engine_go_on_in_another(warp, scene, start):
    _, states = warp
    mujoco_physics = engines.make("mujoco", scene(2))
    after = jax.jit(jax.vmap(mujoco_physics.step))(states, jnp.asarray(start[2]))
    assert not after.diverged.any()
