"""MJX over Warp and in JAX, on the CPU, against MuJoCo in C in double precision.

Both compute in single precision, which is good to about 1e-7 of a metre or radian in free space.
Stiff constraints multiply that: the links of the fingers, which weigh next to nothing, can come out
a milliradian elsewhere after a control step, and a gripped cube ten micrometres. The bounds are a
few times what was seen.
"""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import jax
import mujoco
import numpy as np
import pytest

from pigbench import envs
from pigbench.envs import CubeEnv, control
from pigbench.envs.observation import cube_poses
from pigbench.envs.oracles import PlayPolicy
from pigbench.envs.oracles.play import PlayState
from pigbench.envs.physics import PhysicsState
from pigbench.envs.scene import SUBSTEPS
from pigbench.envs.spec import SUCCESS_DISTANCE
from pigbench.envs.units import PAD_FORCE_SCALE

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
        # It runs for longer than it compiles if it is not optimised at all.
        step = jax.jit(env.physics.step, compiler_options={"xla_backend_optimization_level": 1})
        return Simulator(env, jax.jit(env.physics.init), step)

    return make


def step_in_c(model: mujoco.MjModel, qpos, qvel, ctrl) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.ctrl[:] = qpos, qvel, 0
    mujoco.mj_forward(model, data)
    data.ctrl[:] = ctrl
    mujoco.mj_step(model, data, nstep=SUBSTEPS)
    return data


@pytest.mark.parametrize("engine", ENGINES)
def test_a_control_step_is_that_of_mujoco_in_c(simulator, situations, engine):
    env, init, step = simulator(engine)
    for (situation, bounds), qpos, qvel, ctrl in zip(BOUNDS.items(), *situations, strict=True):
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
    policy = PlayPolicy(env.spec, env.scene)
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
