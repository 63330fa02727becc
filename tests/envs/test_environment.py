"""Resets, steps, goals and success: properties that OGBench's environments have too."""

from functools import partial

import brax.envs.wrappers.training as brax_training
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from brax.envs.base import Env
from scipy import stats

from pigbench import envs
from pigbench.envs import State, workspace
from pigbench.envs.environment import START_JITTER, USER_TASK
from pigbench.errors import UserError

BATCH = 64


def cubes(env: envs.CubeEnv, physics_state) -> tuple[np.ndarray, np.ndarray]:
    """Positions (..., num_cubes, 3) and quaternions (..., num_cubes, 4), in double precision."""
    qpos = np.asarray(physics_state.qpos, float)[..., env.scene.cubes_qpos]
    poses = qpos.reshape(*qpos.shape[:-1], env.scene.num_cubes, 7)
    return poses[..., :3], poses[..., 3:]


def bytes_of(tree) -> bytes:
    return b"".join(np.asarray(leaf).tobytes() for leaf in jax.tree.leaves(tree))


@pytest.fixture(scope="module")
def started(env):
    """`started(name)`: BATCH first states, of random tasks."""
    keys = jax.random.split(jax.random.key(0), BATCH)
    return lambda name: jax.jit(jax.vmap(env(name).reset))(keys)


@pytest.mark.parametrize("name", envs.names())
def test_every_environment_resets_and_steps(env, name):
    one = env(name)
    assert isinstance(one, Env)
    state = jax.jit(one.reset)(jax.random.key(0))
    shape = jax.tree.map(jnp.shape, state)
    after = jax.jit(one.step)(state, jnp.zeros(5))
    assert jax.tree.map(jnp.shape, after) == shape
    assert jax.tree.map(lambda x: x.dtype, after) == jax.tree.map(lambda x: x.dtype, state)
    num_cubes = one.spec.num_cubes
    assert state.obs.shape == state.info["goal"].shape == (one.observation_size,)
    assert one.observation_size == 28 + 9 * (num_cubes - 1)
    assert one.action_size == 5
    assert one.num_tasks == 5
    assert one.backend == "mujoco"
    assert state.info["target"].shape == (num_cubes, 3)
    assert state.obs.dtype == jnp.float32
    assert not after.info["diverged"]


def test_unknown_names_offer_the_nearest():
    with pytest.raises(UserError, match=r"environment 'cube-duble': did you mean 'cube-double'"):
        envs.make("cube-duble")
    with pytest.raises(UserError, match=r"physics engine 'mujoko': did you mean 'mujoco'"):
        envs.make("cube-single", engine="mujoko")
    with pytest.raises(UserError, match=r"physics profile 'fats': did you mean 'fast'"):
        envs.make("cube-single", profile="fats")


def test_profile_is_that_of_the_scene():
    assert envs.make("cube-single", profile="fast").scene.profile == "fast"


def test_jit_vmap_and_scan_agree(env):
    one = env("cube-double")
    keys = jax.random.split(jax.random.key(1), 3)
    actions = jax.random.uniform(jax.random.key(2), (4, 3, 5), minval=-1, maxval=1)
    states = jax.jit(jax.vmap(one.reset_task, in_axes=(0, None)))(keys, 2)
    batch_step, step = jax.vmap(one.step), jax.jit(one.step)
    by_hand = states
    for action in actions:
        by_hand = jax.jit(batch_step)(by_hand, action)
    scanned, _ = jax.jit(
        partial(jax.lax.scan, lambda state, action: (batch_step(state, action), None))
    )(states, actions)
    single = jax.tree.map(lambda x: x[1], states)
    for action in actions[:, 1]:
        single = step(single, action)
    np.testing.assert_allclose(scanned.obs, by_hand.obs, atol=1e-3)
    np.testing.assert_allclose(single.obs, by_hand.obs[1], atol=1e-3)


def test_same_key_same_bytes(env):
    keys = jax.random.split(jax.random.key(3), 8)
    actions = jax.random.uniform(jax.random.key(4), (8, 5), minval=-1, maxval=1)

    def compiled(one: envs.CubeEnv):
        return jax.jit(
            lambda: jax.vmap(lambda key, action: one.step(one.reset(key), action))(keys, actions)
        )

    run = compiled(env("cube-triple"))
    first = bytes_of(run())
    assert first == bytes_of(run())
    assert first == bytes_of(compiled(envs.make("cube-triple"))())


@pytest.mark.parametrize("name", ["cube-double", "cube-octuple"])
def test_reset_task(env, name):
    """Cubes in a random order, starts shifted by up to 1 cm, goals as they stand."""
    one = env(name)
    keys = jax.random.split(jax.random.key(5), BATCH)
    # The last task stacks cubes, so that heights are in play.
    states = jax.jit(jax.vmap(one.reset_task, in_axes=(0, None)))(keys, one.num_tasks)
    task = one.spec.tasks[-1]
    positions, quats = cubes(one, states.pipeline_state)
    targets = np.asarray(states.info["target"])
    np.testing.assert_array_equal(states.info["task"], one.num_tasks)
    orders, shifts = [], []
    for i in range(BATCH):
        order = [np.abs(task.goal_xyz - target).sum(axis=-1).argmin() for target in targets[i]]
        assert sorted(order) == list(range(one.spec.num_cubes))
        np.testing.assert_allclose(targets[i], task.goal_xyz[order], atol=1e-6)
        shift = positions[i] - task.start_xyz[order]
        np.testing.assert_allclose(shift[:, 2], 0, atol=1e-6)
        orders.append(tuple(order))
        shifts.append(shift[:, :2])
    assert np.abs(shifts).max() <= START_JITTER + 1e-6
    uniform = stats.uniform(-START_JITTER, 2 * START_JITTER)
    assert stats.kstest(np.ravel(shifts), uniform.cdf).pvalue > 1e-3
    yaws = np.mod(2 * np.arctan2(quats[..., 3], quats[..., 0]), 2 * np.pi)
    np.testing.assert_array_equal(quats[..., 1:3], 0)
    assert stats.kstest(yaws.ravel(), stats.uniform(0, 2 * np.pi).cdf).pvalue > 1e-3
    counts = np.array([np.sum(np.array(orders)[:, 0] == i) for i in range(one.spec.num_cubes)])
    assert stats.chisquare(counts).pvalue > 1e-3


def test_reset_draws_every_task(started):
    tasks = np.asarray(started("cube-double").info["task"])
    counts = np.bincount(tasks, minlength=6)[1:]
    assert counts.sum() == BATCH
    assert stats.chisquare(counts).pvalue > 1e-3


def test_the_arm_starts_in_its_box(env, started):
    states = started("cube-double")
    pinch = np.asarray(states.pipeline_state.pinch_pos)
    low, high = np.array(workspace.PINCH_START.low), np.array(workspace.PINCH_START.high)
    assert np.all((pinch > low - 1e-5) & (pinch < high + 1e-5))
    for axis in range(3):
        box = stats.uniform(low[axis], high[axis] - low[axis])
        assert stats.kstest(pinch[:, axis], box.cdf).pvalue > 1e-3
    yaw = np.asarray(states.pipeline_state.pinch_yaw)
    assert stats.kstest(yaw, stats.uniform(-np.pi, 2 * np.pi).cdf).pvalue > 1e-3
    assert not states.pipeline_state.qvel.any()
    opening = env("cube-double").layout["gripper_opening"]
    np.testing.assert_array_equal(states.obs[:, opening], 0)


def test_the_goal_is_an_observation_of_the_goal_scene(env, started):
    """Cubes lie unturned where they must go, the arm high after two random steps, not at rest."""
    one, states = env("cube-triple"), started("cube-triple")
    goal, layout = np.asarray(states.info["goal"]), one.layout
    for i in range(3):
        xyz = goal[:, layout[f"cube_{i}_pos"]] / 10 + [0.425, 0, 0]
        np.testing.assert_allclose(xyz, states.info["target"][:, i], atol=1e-3)
        np.testing.assert_allclose(goal[:, layout[f"cube_{i}_yaw"]], [[1, 0]] * BATCH, atol=1e-2)
    height = goal[:, layout["effector_pos"]][:, 2] / 10
    # It began at 20 cm or higher, and two steps of at most 5 cm lower it by less than 10 cm.
    assert height.min() > 0.1
    assert height.max() < workspace.PINCH.high[2] + 0.05
    assert np.abs(goal[:, layout["joint_vel"]]).max(axis=-1).min() > 1e-3
    # Another arm pose than the start's, and another in every episode.
    here = np.asarray(states.obs)[:, layout["effector_pos"]]
    assert np.abs(here - goal[:, layout["effector_pos"]]).max(axis=-1).min() > 1e-2
    assert len(np.unique(height)) == BATCH


def test_reset_to_poses_of_the_user(env):
    one = env("cube-double")
    start = np.array([[0.35, -0.1, 0.02], [0.5, 0.2, 0.02]])
    goal = np.array([[0.45, 0.1, 0.02], [0.45, 0.1, 0.06]])
    state = jax.jit(one.reset_to)(jax.random.key(0), start, goal)
    assert state.info["task"] == USER_TASK
    np.testing.assert_allclose(state.info["target"], goal, atol=1e-6)
    shift = cubes(one, state.pipeline_state)[0] - start
    assert 0 < np.abs(shift[:, :2]).max() <= START_JITTER + 1e-6
    np.testing.assert_allclose(shift[:, 2], 0, atol=1e-6)


def test_random_scenes_fill_the_table(env):
    one = env("cube-double")
    states = jax.jit(jax.vmap(one.random_scene))(jax.random.split(jax.random.key(6), 256))
    positions, quats = cubes(one, states)
    np.testing.assert_allclose(positions[..., 2], 0.02, atol=1e-7)
    for axis in range(2):
        low, high = workspace.CUBE.low[axis], workspace.CUBE.high[axis]
        uniform = stats.uniform(low, high - low)
        assert stats.kstest(positions[..., axis].ravel(), uniform.cdf).pvalue > 1e-3
    yaws = np.mod(2 * np.arctan2(quats[..., 3], quats[..., 0]), 2 * np.pi)
    assert stats.kstest(yaws.ravel(), stats.uniform(0, 2 * np.pi).cdf).pvalue > 1e-3


def with_cubes_off_target(env: envs.CubeEnv, offsets: np.ndarray) -> State:
    """States at rest with the cubes `offsets` (batch, num_cubes) metres off target in x."""
    targets = np.array([[0.4, -0.15, 0.02], [0.45, 0.15, 0.02]])
    states = jax.jit(jax.vmap(env.reset_to, in_axes=(0, None, None)))(
        jax.random.split(jax.random.key(0), len(offsets)), targets, targets
    )
    cubes = np.tile(np.concatenate([targets, [[1, 0, 0, 0]] * 2], axis=-1), (len(offsets), 1, 1))
    cubes[..., 0] += offsets
    qpos = states.pipeline_state.qpos.at[:, env.scene.cubes_qpos].set(cubes.reshape(-1, 14))
    return states.replace(pipeline_state=states.pipeline_state.replace(qpos=qpos))


def test_success_is_every_cube_within_four_centimetres(env, ogbench_env):
    one = env("cube-double")
    near, far = 0.0399, 0.0401
    offsets = np.array([[near, -near], [far, near], [near, -far], [far, far], [0, 0]])
    after = jax.jit(jax.vmap(one.step))(with_cubes_off_target(one, offsets), jnp.zeros((5, 5)))
    expected = [True, False, False, False, True]
    theirs = ogbench_env("cube-double", "task")
    for row in range(5):
        assert bool(after.info["success"][row]) == expected[row]
        assert (
            after.reward[row] == after.done[row] == after.metrics["success"][row] == expected[row]
        )
        for i, (xyz, target) in enumerate(
            zip(cubes(one, after.pipeline_state)[0][row], after.info["target"][row], strict=True)
        ):
            theirs._data.joint(f"object_joint_{i}").qpos[:3] = xyz
            theirs._data.mocap_pos[theirs._cube_target_mocap_ids[i]] = target
        assert all(theirs._compute_successes()) == expected[row]


def test_a_state_that_is_done_stays_as_it_is(env):
    one = env("cube-double")
    states = with_cubes_off_target(one, np.array([[0.0, 0.0], [0.1, 0.1]]))
    step = jax.jit(jax.vmap(one.step))
    after = step(states, jnp.ones((2, 5)))
    again = step(after, -jnp.ones((2, 5)))
    assert list(after.done) == [1, 0]
    frozen, moving = (jax.tree.map(lambda x, i=i: x[i], (after, again)) for i in range(2))
    assert bytes_of(frozen[0]) == bytes_of(frozen[1])
    assert bytes_of(moving[0]) != bytes_of(moving[1])


@pytest.mark.parametrize("what", ["lost cube", "fast arm", "mad action"])
def test_divergence_ends_the_episode_as_a_failure(env, what):
    one = env("cube-double")
    states = with_cubes_off_target(one, np.array([[0.0, 0.0], [0.1, 0.1], [0.0, 0.0]]))
    actions = jnp.zeros((3, 5))
    step = jax.jit(jax.vmap(one.step))
    well = step(states, actions)
    physics_state = states.pipeline_state
    if what == "lost cube":
        physics_state = physics_state.replace(qpos=physics_state.qpos.at[2, 14].set(jnp.nan))
    elif what == "fast arm":
        physics_state = physics_state.replace(qvel=physics_state.qvel.at[2, 1].set(1e6))
    else:
        actions = actions.at[2].set(jnp.nan)
    after = step(states.replace(pipeline_state=physics_state), actions)
    assert list(after.info["diverged"]) == [False, False, True]
    assert list(after.info["success"]) == [True, False, False]
    assert list(after.done) == [1, 0, 1]
    assert list(after.reward) == [1, 0, 0]
    for row in range(2):
        pair = (jax.tree.map(lambda x, row=row: x[row], state) for state in (after, well))
        assert bytes_of(next(pair)) == bytes_of(next(pair))


def test_brax_wrappers(env):
    one = env("cube-single")
    limit = 4
    wrapped = brax_training.wrap(one, episode_length=limit, action_repeat=1)
    # Brax reads the batch's size off untyped keys.
    first = jax.jit(wrapped.reset)(jax.random.split(jax.random.PRNGKey(0), 3))
    # The third one's cube is put on its target: it succeeds at once.
    on_target = first.pipeline_state.qpos.at[2, 14:17].set(first.info["target"][2, 0])
    states = first.replace(pipeline_state=first.pipeline_state.replace(qpos=on_target))
    dones, observations = [], []
    step = jax.jit(wrapped.step)
    for _ in range(limit + 1):
        states = step(states, jnp.full((3, 5), 0.5))
        dones.append(np.asarray(states.done))
        observations.append(np.asarray(states.obs))
    np.testing.assert_array_equal(dones, [[0, 0, 1], [0, 0, 0], [0, 0, 0], [1, 1, 0], [0, 0, 1]])
    # An ended episode starts over from its first state.
    np.testing.assert_array_equal(observations[0][2], first.obs[2])
    np.testing.assert_array_equal(observations[3][:2], first.obs[:2])
    np.testing.assert_array_equal(observations[4][:2], observations[0][:2])
    # Truncation is the limit's, not success.
    np.testing.assert_array_equal(states.info["truncation"], [0, 0, 1])
