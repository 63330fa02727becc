"""MJX over Warp and in JAX, on the CPU, against MuJoCo in C in double precision.

Both compute in single precision, which is good to about 1e-7 of a metre or radian in free space.
Contact multiplies that: where a cube is gripped or stacked, stiff constraints turn rounding into
micrometres within a control step. The bounds are some ten times what was seen.
"""

import importlib.util

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest

from pigbench import envs
from pigbench.envs import physics as engines
from pigbench.envs.environment import SUCCESS_DISTANCE
from pigbench.envs.observation import cube_poses
from pigbench.envs.oracles import PlayPolicy
from pigbench.envs.physics import mjx
from pigbench.envs.physics.mjx import MjxJax, MjxWarp
from pigbench.envs.scene import SUBSTEPS
from pigbench.errors import UserError

NAME = "cube-double"
ENGINES = [MjxWarp, pytest.param(MjxJax, marks=pytest.mark.slow)]

# Situation -> bounds on positions (metres, radians) and on the contact number after one step.
BOUNDS = {"free": (2e-6, 1e-6), "grasp": (5e-5, 2e-3), "stack": (5e-5, 1e-3)}


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


def step_in_c(model: mujoco.MjModel, qpos, qvel, ctrl) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.ctrl[:] = qpos, qvel, 0
    mujoco.mj_forward(model, data)
    data.ctrl[:] = ctrl
    mujoco.mj_step(model, data, nstep=SUBSTEPS)
    return data


@pytest.mark.parametrize("engine", ENGINES)
def test_a_control_step_is_that_of_mujoco_in_c(scene, start, engine):
    physics = engine(scene(2))
    qpos, qvel, ctrl = start
    states = jax.jit(jax.vmap(physics.init))(qpos, qvel)
    after = jax.jit(jax.vmap(physics.step))(states, ctrl)
    assert not after.diverged.any()
    for i, (situation, (position, contact)) in enumerate(BOUNDS.items()):
        data = step_in_c(scene(2).model, *(x[i] for x in start))
        pinch, pad = data.site("pinch"), data.body("right_pad")
        error = np.abs(after.qpos[i] - data.qpos)
        force = np.abs(after.pad_force[i] - np.linalg.norm(pad.cfrc_ext))
        print(f"{engine.name}, {situation}: {error.max():.1e}, contact {force / 50:.1e}")
        np.testing.assert_array_less(error, position, err_msg=situation)
        np.testing.assert_allclose(after.pinch_pos[i], pinch.xpos, atol=position)
        assert force / 50 < contact
    assert after.pad_force[1] > 10  # the grasp is one


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["mujoco", "mjx-warp", "mjx-jax"])
def test_picks_and_places_a_cube(engine):
    """The scripted policy's plan, of fewer than 200 control steps, brings the cube there."""
    env = envs.make("cube-single", engine=engine)
    policy = PlayPolicy(env.scene)

    @jax.jit
    def carry_out(key):
        scene_key, policy_key = jax.random.split(key)
        begin = env.random_scene(scene_key)
        memory = policy.reset(policy_key, begin)

        def step(carry):
            state, memory = carry
            state = env.simulate(state, policy.act(key, memory, state))
            return state, memory.replace(time=memory.time + 1)

        going_on = lambda carry: carry[1].time < memory.plan.length  # noqa: E731
        state, last = jax.lax.while_loop(going_on, step, (begin, memory))
        return begin, state, last

    begin, state, memory = carry_out(jax.random.key(3))
    assert 50 < memory.time < 200
    assert not state.diverged
    target = memory.target.pos
    far, near = (
        np.linalg.norm(cube_poses(env.scene, one)[0][0] - target) for one in (begin, state)
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


@pytest.mark.parametrize("room", ["_CUBE_CONTACTS", "_ROWS"])
def test_want_of_room_for_contacts_or_rows_is_reported(monkeypatch, capfd, scene, start, room):
    monkeypatch.setattr(mjx, "_GRASP_CONTACTS", 2 if room == "_CUBE_CONTACTS" else 32)
    monkeypatch.setattr(mjx, room, 1)
    physics = MjxWarp(scene(2))
    states = jax.jit(jax.vmap(physics.init))(*start[:2])
    after = jax.jit(jax.vmap(physics.step))(states, start[2])
    assert after.overflow.any()
    np.testing.assert_array_equal(after.diverged, after.overflow)
    assert "overflow" not in capfd.readouterr().out  # the flag says it, Warp need not


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
