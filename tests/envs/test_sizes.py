"""Environments with numbers of cubes that none of pigbench's own has."""

from dataclasses import replace

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest

from pigbench.envs import CubeEnv, EnvSpec, Task
from pigbench.envs.cubes import MAX_CUBES
from pigbench.envs.observation import cube_poses
from pigbench.envs.oracles import POLICIES
from pigbench.envs.physics import MujocoPhysics
from pigbench.envs.scripted import SCRIPTED
from pigbench.envs.walls import WALLS
from pigbench.errors import UserError

COLUMNS = 4


def spec(num_cubes: int) -> EnvSpec:
    """From a grid, 10 cm apart, to the same grid 1 cm away."""
    start = tuple((0.3 + 0.07 * (i // COLUMNS), 0.1 * (i % COLUMNS)) for i in range(num_cubes))
    goal = tuple((x + 0.01, y) for x, y in start)
    return EnvSpec(f"cube-{num_cubes}", num_cubes, 100, (Task("shift", start, goal),))


def make(scene, num_cubes: int) -> CubeEnv:
    return CubeEnv(spec(num_cubes), MujocoPhysics(scene(num_cubes), threads=1))


def test_what_policies_can_do_is_known_without_their_code():
    assert {name: policy.ability for name, policy in POLICIES.items()} == SCRIPTED


@pytest.mark.parametrize("num_cubes", [1, 2, 5, 6, 7, 9, 12, MAX_CUBES])
@pytest.mark.parametrize("name", POLICIES)
def test_every_policy_acts_with_as_many_cubes_as_it_can_move(scene, name, num_cubes):
    env = make(scene, num_cubes)
    key = jax.random.key(0)
    if num_cubes > POLICIES[name].ability.most_cubes:
        refusal = f"cube-{num_cubes} has {num_cubes} cubes, and .* moves no more than"
        with pytest.raises(UserError, match=refusal):
            POLICIES[name](env.spec, env.scene)
        return
    policy = POLICIES[name](env.spec, env.scene)

    def act() -> tuple[jax.Array, jax.Array]:
        physics_state = env.random_scene(key)
        memory = policy.reset(key, physics_state)
        after = env.simulate(physics_state, policy.act(key, memory, physics_state))
        memory = policy.advance(key, memory, after)
        return env.observe(after), policy.act(key, memory, after)

    shapes = jax.tree.map(jnp.shape, jax.eval_shape(act))
    assert shapes == ((19 + 9 * num_cubes,), (5,))


def test_nine_cubes_start_at_their_places_and_end_at_their_targets(scene):
    env = make(scene, 9)
    state = jax.jit(env.reset_task)(jax.random.key(1), 1)
    start, _ = cube_poses(env.scene, state.pipeline_state)
    # Each starts within 1 cm in x and y of 1 cm before its target.
    shift = np.asarray(start - state.info["target"])
    np.testing.assert_allclose(shift, np.broadcast_to([-0.01, 0, 0], (9, 3)), atol=0.0101)
    after = jax.jit(env.step)(state, jnp.zeros(5))
    assert after.info["success"]
    assert after.reward == 1


@pytest.mark.parametrize("num_cubes", [8, 9, MAX_CUBES])
def test_at_home_cubes_rest_beside_each_other_between_the_walls(scene, num_cubes):
    model = scene(num_cubes).model
    data = mujoco.MjData(model)
    data.qpos[:] = scene(num_cubes).home_qpos
    mujoco.mj_forward(model, data)
    x, y = data.xpos[scene(num_cubes).cube_bodies, :2].T
    near, far = (WALLS[name][1][0] for name in ("wall_near", "wall_far"))
    right, left = (WALLS[name][1][1] for name in ("wall_right", "wall_left"))
    assert np.all((x > near + 0.02) & (x < far - 0.02) & (y > right + 0.02) & (y < left - 0.02))
    between = [{model.geom(i).name for i in contact.geom} for contact in data.contact]
    assert not [pair for pair in between if "floor" not in pair]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"num_cubes": 17}, "'cube-5' has 17 cubes: there is room for 1 to 16"),
        ({"num_cubes": 0}, "'cube-5' has 0 cubes"),
        (
            {"num_cubes": 6},
            "6 cubes, but 'shift' places 5 at the start and 5 at the goal",
        ),
        ({"tasks": ()}, "has no tasks"),
        ({"episode_length": 0}, "episodes of 0 control steps"),
        ({"stacking": (0.5, 0.2)}, "probability from 0.5 to 0.2"),
        ({"stacking": (0.0, 1.5)}, "probability from 0.0 to 1.5"),
        (
            {"policy": "replan"},
            "'cube-5' has 5 cubes, and its policy 'replan' moves no more than 1",
        ),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(changes, message):
    with pytest.raises(UserError, match=message) as refusal:
        replace(spec(5), **changes)
    assert "\n" not in str(refusal.value)
