"""The play policy: plan after plan, and its success beside that of OGBench's own oracle."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats

from pigbench.envs import SPECS, control
from pigbench.envs.oracles import POLICIES, PlayPolicy
from pigbench.envs.units import ACTION_SCALE

NAME = "cube-double"
STACKING = SPECS[NAME].stacking


@pytest.fixture(scope="module")
def policy(env) -> PlayPolicy:
    return PlayPolicy(env(NAME).spec, env(NAME).scene)


def test_by_name():
    assert POLICIES["play"] is PlayPolicy


def test_an_episode_begins_with_a_plan_for_a_cube_of_the_scene(env, begun):
    physics_state, memory = begun
    assert set(np.asarray(memory.target.cube)) == {0, 1}
    low, high = STACKING
    uniform = stats.uniform(low, high - low)
    assert stats.kstest(memory.stacking, uniform.cdf).pvalue > 1e-3
    # The first target stacks half of the time, whatever the episode's probability.
    stacked = int(np.sum(memory.target.pos[:, 2] > 0.05))
    assert stats.binomtest(stacked, 64, 0.5).pvalue > 1e-3
    np.testing.assert_array_equal(memory.time, 0)
    # The plan sets out from the effector, save for noise of 10 % of the action scale.
    effector = jax.vmap(lambda state: control.effector(env(NAME).scene, state))(physics_state)
    off = (memory.plan.targets[:, 0] - effector) / np.array(ACTION_SCALE)
    off = off.at[:, 3].set(0)  # yaw is written within one turn
    assert np.abs(off).max() < 0.5


def test_the_action_is_the_way_to_the_plans_next_target(env, policy, begun):
    physics_state, memory = begun
    memory = memory.replace(time=jnp.arange(64))
    ours = jax.vmap(policy.act, in_axes=(None, 0, 0))(jax.random.key(0), memory, physics_state)
    scene = env(NAME).scene
    effector = jax.vmap(lambda state: control.effector(scene, state))(physics_state)
    target = np.asarray(memory.plan.targets)[np.arange(64), np.arange(64)]
    expected = np.clip((target - effector) / np.array([0.05, 0.05, 0.05, 0.3, 1.0]), -1, 1)
    np.testing.assert_allclose(ours, expected, atol=1e-5)
    assert np.all(np.abs(ours) <= 1)


def test_plan_after_plan(policy, begun):
    physics_state, memory = begun
    advance = jax.jit(jax.vmap(policy.advance))
    last = memory.plan.length - 1
    before, at = memory.replace(time=last - 1), memory.replace(time=last)
    assert not jax.vmap(policy.ended)(before).any()
    assert jax.vmap(policy.ended)(at).all()
    keys = jax.random.split(jax.random.key(1), 64)
    on, fresh = advance(keys, before, physics_state), advance(keys, at, physics_state)
    np.testing.assert_array_equal(on.time, last)
    np.testing.assert_array_equal(on.plan.targets, memory.plan.targets)
    np.testing.assert_array_equal(fresh.time, 0)
    assert np.all(np.any(fresh.plan.targets != memory.plan.targets, axis=(1, 2)))
    # The episode keeps its probability of stacking, which now counts.
    np.testing.assert_array_equal(fresh.stacking, memory.stacking)
    stacked = np.sum(fresh.target.pos[:, 2] > 0.05)
    assert stacked < 0.35 * 64


EPISODES, EPISODE_STEPS = 20, 1000


def their_successes(play) -> list[np.ndarray]:
    stacking = np.random.default_rng(7).uniform(*STACKING, EPISODES)
    episodes = [play(NAME, EPISODE_STEPS, seed, stacking[seed]) for seed in range(EPISODES)]
    return [episode.success[episode.ended] for episode in episodes]


@pytest.mark.slow
def test_succeeds_as_often_as_ogbenchs_oracle(play, our_successes):
    """About 220 sub-tasks each. Those of an episode share its mishaps, so episodes are compared."""
    ours, theirs = our_successes(EPISODES, EPISODE_STEPS), their_successes(play)
    assert min(sum(map(len, episodes)) for episodes in (ours, theirs)) >= 200
    one, other = (np.array([row.mean() for row in episodes]) for episodes in (ours, theirs))
    print(f"{one.mean():.1%} of the sub-tasks, OGBench {other.mean():.1%}")
    error = np.sqrt((one.var(ddof=1) + other.var(ddof=1)) / EPISODES)
    assert one.mean() >= other.mean() - stats.norm.ppf(0.95) * error
