"""The policy that plans anew: what it brings about, and when it fetches or gives up."""

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from pigbench import envs
from pigbench.data import collect
from pigbench.envs.oracles import ReplanPolicy, replan
from pigbench.envs.reality import Reality

EPISODES = 6
STAGES = list(replan.STAGES)


@pytest.fixture(scope="module")
def zero():
    return envs.make("cube-centre", reality=Reality())


@pytest.fixture(scope="module")
def policy(zero):
    return ReplanPolicy(zero.spec, zero.scene)


@pytest.fixture(scope="module")
def episodes(zero, policy):
    """Rows of episodes without noise: (live, trip, cube positions), (rows, EPISODES, ...)."""

    @jax.jit
    def run(keys):
        begun = jax.vmap(partial(collect.begin, zero, policy))(keys, jnp.zeros(EPISODES, bool))

        def step(batch, _):
            after, row = jax.vmap(partial(collect.step, zero, policy))(batch)
            cubes = row["qpos"][:, zero.scene.cubes_qpos][:, :3]
            return after, (row["live"], batch.memory.trip, cubes)

        last, rows = jax.lax.scan(step, begun, length=policy.ability.episode_rows)
        return last.memory.away, rows

    return jax.device_get(run(jax.random.split(jax.random.key(0), EPISODES)))


def test_the_cube_is_brought_to_the_centre_and_away(episodes):
    away, (live, trip, cubes) = episodes
    for number in range(EPISODES):
        rows = live[:, number].sum()
        assert live[:rows, number].all()
        turn = np.argmax(trip[:, number] == 1)
        assert 30 < turn < rows - 30 < 271
        np.testing.assert_allclose(cubes[turn, number], [0.425, 0, 0.02], atol=0.015)
        np.testing.assert_allclose(cubes[rows - 1, number, :2], away[number], atol=0.015)


def test_home_is_the_goal_that_all_tasks_share():
    centre, single = envs.SPECS["cube-centre"], envs.SPECS["cube-single"]
    elsewhere = replace(centre, tasks=(replace(centre.tasks[0], goal=((0.5, 0.1),)),))
    assert replan.home(elsewhere) == (0.5, 0.1)
    assert replan.home(centre) == centre.tasks[0].goal[0]
    assert replan.home(single) == pytest.approx((0.425, 0.0))  # the centre: its tasks differ


def test_the_cube_is_brought_to_a_goal_elsewhere(zero, begun):
    _, physics = begun
    tasks = (replace(zero.spec.tasks[0], goal=((0.5, 0.1),)),)
    policy = ReplanPolicy(replace(zero.spec, tasks=tasks), zero.scene)
    state = policy.reset(jax.random.key(3), physics)
    np.testing.assert_allclose(policy.target(state).pos, [0.5, 0.1, 0.02], rtol=1e-6)


@pytest.fixture(scope="module")
def begun(zero, policy):
    key = jax.random.key(3)
    physics = zero.random_scene(key)
    return policy.reset(key, physics), physics


def advanced(policy, state, physics):
    return jax.jit(policy.advance)(jax.random.key(0), state, physics)


def test_a_cube_that_is_lost_is_fetched_again(policy, begun):
    state, physics = begun
    carrying = replace(state, stage=jnp.asarray(STAGES.index("above_place")))
    assert advanced(policy, carrying, physics).stage == 0
    gripped = replace(physics, pad_force=jnp.asarray(50.0))
    assert advanced(policy, carrying, gripped).stage == STAGES.index("above_place")


def test_a_trip_is_given_up_in_the_end(policy, begun):
    state, physics = begun
    late = replace(state, time=jnp.asarray(replan.TRIP_STEPS - 1), waited=jnp.asarray(2))
    after = advanced(policy, late, physics)
    assert (after.trip, after.time, after.waited) == (1, 0, 0)
    assert not policy.finished(after)
    assert policy.finished(advanced(policy, replace(late, trip=jnp.asarray(1)), physics))


def test_a_cube_put_down_elsewhere_is_fetched_again(policy, begun):
    state, physics = begun
    stage = jnp.asarray(STAGES.index("retreat"))
    through = replace(state, stage=stage, lift=physics.pinch_pos[2])
    after = advanced(policy, through, physics)
    assert (after.trip, after.stage) == (0, 0)


def test_no_action_exceeds_the_episodes_speed(policy, begun):
    state, physics = begun
    action = np.asarray(policy.act(jax.random.key(0), state, physics))
    np.testing.assert_allclose(np.abs(action[:4]).max(), state.speed, rtol=1e-5)
    assert action[4] == -1  # open
