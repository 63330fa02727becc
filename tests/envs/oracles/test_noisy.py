"""The noisy policy: OGBench's decisions from OGBench's states, its noise, its success."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from ogbench.manipspace.oracles.markov.cube_markov import CubeMarkovOracle
from scipy import stats

from pigbench.envs import SPECS
from pigbench.envs.observation import cube_poses
from pigbench.envs.oracles import POLICIES, NoisyPolicy, markov
from pigbench.envs.oracles.noisy import NoisyState
from pigbench.envs.oracles.targets import Target

NAME = "cube-double"
STACKING = SPECS[NAME].stacking


@pytest.fixture(scope="module")
def policy(env) -> NoisyPolicy:
    return NoisyPolicy(env(NAME).spec, env(NAME).scene)


def test_by_name():
    assert POLICIES["noisy"] is NoisyPolicy


def test_an_episodes_draws(begun):
    _, memory = begun
    for values, low, high in (
        (memory.stacking, *STACKING),
        (memory.noise, 0.0, 0.1),
        (memory.final.pos[:, 0], 0.25, 0.6),
        (memory.final.pos[:, 1], -0.35, 0.35),
        (memory.final.pos[:, 2], 0.2, 0.35),
        (memory.final.yaw, -np.pi, np.pi),
    ):
        assert stats.kstest(values, stats.uniform(low, high - low).cdf).pvalue > 1e-3
    assert set(np.asarray(memory.target.cube)) == {0, 1}
    np.testing.assert_array_equal(memory.time, 0)
    assert not memory.done.any()


def test_noise_is_gaussian_three_and_ten_times_on_yaw_and_gripper(monkeypatch, policy, begun):
    monkeypatch.setattr(markov, "action", lambda *_: jnp.zeros(5))
    physics_state, memory = jax.tree.map(lambda x: x[0], begun)
    memory = memory.replace(noise=0.02)  # so small that the limits of an action are far off
    keys = jax.random.split(jax.random.key(1), 4000)
    actions = jax.vmap(policy.act, in_axes=(0, None, None))(keys, memory, physics_state)
    for axis, scale in enumerate((0.02, 0.02, 0.02, 0.06, 0.2)):
        assert stats.kstest(actions[:, axis], stats.norm(0, scale).cdf).pvalue > 1e-3
    correlations = np.corrcoef(np.asarray(actions).T) - np.eye(5)
    assert np.abs(correlations).max() < 0.08


def test_actions_stay_within_their_limits(policy, begun):
    physics_state, memory = begun
    keys = jax.random.split(jax.random.key(2), 64)
    actions = jax.vmap(policy.act)(keys, memory.replace(noise=jnp.ones(64)), physics_state)
    np.testing.assert_allclose(np.abs(actions).max(), 1.0)


def test_decides_as_ogbenchs_oracle_from_states_of_its_play(env, policy, place, play):
    recording = play(NAME, 400)
    rng = np.random.default_rng(3)
    oracle = CubeMarkovOracle(env=place(NAME, recording.qpos[0]))
    act = jax.jit(policy.act)
    init = jax.jit(env(NAME).physics.init)
    for row in range(0, 400, 10):
        theirs = place(NAME, recording.qpos[row], recording.qvel[row])
        theirs.set_new_target(return_info=False)
        info = theirs.compute_ob_info()
        oracle._final_pos = rng.uniform([0.25, -0.35, 0.2], [0.6, 0.35, 0.35])
        oracle._final_yaw = rng.uniform(-np.pi, np.pi)
        oracle._step = 0
        memory = policy_memory(info, oracle, time=0)
        ours = act(jax.random.key(0), memory, init(recording.qpos[row], recording.qvel[row]))
        np.testing.assert_allclose(ours, oracle.select_action(None, info), atol=1e-3)


def policy_memory(info: dict, oracle: CubeMarkovOracle, time: int) -> NoisyState:
    return NoisyState(
        stacking=jnp.zeros(()),
        noise=jnp.zeros(()),
        target=Target(
            cube=jnp.array(info["privileged/target_block"]),
            pos=jnp.array(info["privileged/target_block_pos"]),
            yaw=jnp.array(info["privileged/target_block_yaw"][0]),
        ),
        final=markov.Pose(jnp.array(oracle._final_pos), jnp.array(oracle._final_yaw)),
        time=jnp.array(time),
        done=jnp.array(False),
    )


def test_target_after_target(policy, begun):
    physics_state, memory = begun
    advance = jax.jit(jax.vmap(policy.advance))
    keys = jax.random.split(jax.random.key(4), 64)
    on = advance(keys, memory.replace(time=jnp.full(64, 198)), physics_state)
    np.testing.assert_array_equal(on.time, 199)
    np.testing.assert_array_equal(on.target.pos, memory.target.pos)
    assert jax.vmap(policy.ended)(on).all()  # the 200th action is the last
    for over in (on, memory.replace(done=jnp.ones(64, bool))):
        fresh = advance(keys, over, physics_state)
        np.testing.assert_array_equal(fresh.time, 0)
        assert not np.any(np.all(fresh.target.pos == memory.target.pos, axis=-1))
        np.testing.assert_array_equal(fresh.stacking, memory.stacking)
        np.testing.assert_array_equal(fresh.noise, memory.noise)


def test_notices_that_cube_and_arm_have_arrived(policy, begun):
    physics_state, memory = begun
    cubes = jax.vmap(lambda state: cube_poses(policy.scene, state)[0])(physics_state)
    at_cube = np.asarray(cubes)[np.arange(64), np.asarray(memory.target.cube)]
    arrived = memory.replace(
        target=memory.target.replace(pos=jnp.asarray(at_cube)),
        final=memory.final.replace(pos=physics_state.pinch_pos),
    )
    keys = jax.random.split(jax.random.key(5), 64)
    after = jax.vmap(policy.advance)(keys, arrived, physics_state)
    assert after.done.all()
    np.testing.assert_array_equal(after.time, 1)


EPISODES, EPISODE_STEPS = 16, 1000


def their_successes(theirs) -> list[np.ndarray]:
    """The same of OGBench's oracle in OGBench's simulator, with noise drawn here."""
    rng = np.random.default_rng(7)
    oracle = CubeMarkovOracle(env=theirs)
    episodes = []
    for seed in range(EPISODES):
        noise, stacking = rng.uniform(0, 0.1), rng.uniform(*STACKING)
        scales = noise * np.array([1, 1, 1, 3, 10])
        observation, info = theirs.reset(seed=seed)
        oracle.reset(observation, info)
        successes = []
        for _ in range(EPISODE_STEPS):
            action = oracle.select_action(observation, info) + rng.normal(0, scales)
            observation, _, _, _, info = theirs.step(np.clip(action, -1, 1))
            if oracle.done:
                successes.append(info["success"])
                observation, info = theirs.set_new_target(p_stack=stacking)
                oracle.reset(observation, info)
        episodes.append(np.array(successes))
    return episodes


@pytest.mark.slow
def test_succeeds_as_often_as_ogbenchs_oracle(ogbench_env, numpy_seed, our_successes):
    """Sub-tasks of an episode share its noise and mishaps, so episodes are compared."""
    with numpy_seed(0):
        theirs = their_successes(ogbench_env(NAME))
    ours = our_successes(EPISODES, EPISODE_STEPS)
    for measure in (np.mean, len):
        one, other = (np.array([measure(row) for row in rows]) for rows in (ours, theirs))
        print(f"{measure.__name__}: {one.mean():.3f}, OGBench {other.mean():.3f}")
        error = np.sqrt((one.var(ddof=1) + other.var(ddof=1)) / EPISODES)
        assert abs(one.mean() - other.mean()) <= stats.norm.ppf(0.995) * error
