"""Resets, steps, goals and success: properties that OGBench's environments have too."""

from functools import cache, partial

import brax.envs.wrappers.training as brax_training
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from brax.envs.base import Env
from scipy import stats
from scipy.spatial.transform import Rotation

from pigbench import envs
from pigbench.envs import State, workspace
from pigbench.envs.environment import NO_TASK, USER_TASK
from pigbench.envs.tasks import START_JITTER
from pigbench.errors import UserError

BATCH = 64
KEYS = jax.random.split(jax.random.key(0), BATCH)


def cubes(env: envs.CubeEnv, physics_state) -> tuple[np.ndarray, np.ndarray]:
    """Positions (..., num_cubes, 3) and quaternions (..., num_cubes, 4), in double precision."""
    qpos = np.asarray(physics_state.qpos, float)[..., env.scene.cubes_qpos]
    poses = qpos.reshape(*qpos.shape[:-1], env.scene.num_cubes, 7)
    return poses[..., :3], poses[..., 3:]


def bytes_of(tree) -> bytes:
    return b"".join(np.asarray(leaf).tobytes() for leaf in jax.tree.leaves(tree))


@pytest.fixture(scope="module")
def reset(env):
    """`reset(name)`: `env.reset` of a batch of keys, compiled once."""
    return cache(lambda name: jax.jit(jax.vmap(env(name).reset)))


@pytest.fixture(scope="module")
def step(env):
    """`step(name)`: `env.step` of a batch of states and actions, compiled once."""
    return cache(lambda name: jax.jit(jax.vmap(env(name).step)))


@pytest.fixture(scope="module")
def started(reset):
    """`started(name)`: BATCH first states, of random tasks."""
    return cache(lambda name: reset(name)(KEYS))


@pytest.mark.parametrize("name", envs.names())
def test_every_environment_resets_and_steps(env, started, step, name):
    one, states = env(name), started(name)
    after = step(name)(states, jnp.zeros((BATCH, 5)))
    assert jax.tree.map(jnp.shape, after) == jax.tree.map(jnp.shape, states)
    assert jax.tree.map(lambda x: x.dtype, after) == jax.tree.map(lambda x: x.dtype, states)
    num_cubes, real = one.spec.num_cubes, one.spec.reality is not None
    assert states.obs.shape == states.info["goal"].shape == (BATCH, one.observation_size)
    assert one.observation_size == 28 + 9 * (num_cubes - 1) - 3 * real
    assert one.action_size == 5
    assert one.num_tasks == (1 if real else 5)
    assert one.backend == "mujoco"
    assert isinstance(one, Env)
    assert states.info["target"].shape == (BATCH, num_cubes, 3)
    assert states.obs.dtype == jnp.float32
    assert not after.info["diverged"].any()
    assert not states.done.any()


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
    one = env("cube-single")
    actions = jax.random.uniform(jax.random.key(2), (4, 3, 5), minval=-1, maxval=1)
    states = jax.jit(jax.vmap(one.reset_task, in_axes=(0, None)))(KEYS[:3], 2)
    np.testing.assert_array_equal(states.info["task"], 2)
    batched, single = jax.vmap(one.step), jax.jit(one.step)
    scanned, _ = jax.jit(
        partial(jax.lax.scan, lambda state, action: (batched(state, action), None))
    )(states, actions)
    for i in range(3):
        state = jax.tree.map(lambda x, i=i: x[i], states)
        for action in actions[:, i]:
            state = single(state, action)
        np.testing.assert_allclose(state.obs, scanned.obs[i], atol=1e-3)


@pytest.mark.parametrize("task", [0, 6, -1, np.int32(6), jnp.array(6)])
def test_a_task_that_is_none_is_refused(env, task):
    with pytest.raises(UserError, match=f"task is {task}: cube-single has tasks 1 to 5"):
        env("cube-single").reset_task(KEYS[0], task)


def test_a_traced_task_that_is_none_is_marked(env):
    reset = jax.jit(jax.vmap(env("cube-single").reset_task, in_axes=(None, 0)))
    given = jnp.arange(-1, 8)
    states = reset(KEYS[0], given)
    np.testing.assert_array_equal(states.info["task"][2:7], given[2:7])
    np.testing.assert_array_equal(states.info["task"][jnp.array([0, 1, 7, 8])], NO_TASK)
    np.testing.assert_array_equal(states.info["target"][7:], states.info["target"][6:8])


def test_same_key_same_bytes(reset, started, step):
    name = "cube-double"
    states = started(name)
    actions = jax.random.uniform(jax.random.key(4), (BATCH, 5), minval=-1, maxval=1)
    assert bytes_of(reset(name)(KEYS)) == bytes_of(states)
    assert bytes_of(step(name)(states, actions)) == bytes_of(step(name)(states, actions))
    # Another instance, of another compilation.
    afresh = jax.jit(jax.vmap(envs.make(name).reset))(KEYS)
    assert bytes_of(afresh) == bytes_of(states)
    assert bytes_of(reset(name)(KEYS[::-1])) != bytes_of(states)


@pytest.mark.parametrize("name", ["cube-double", "cube-octuple"])
def test_tasks_start(env, started, name):
    """Cubes in a random order, starts shifted by up to 1 cm, goals as they stand."""
    one, states = env(name), started(name)
    num_cubes = one.spec.num_cubes
    positions, quats = cubes(one, states.pipeline_state)
    orders, shifts = [], []
    for i, number in enumerate(states.info["task"]):
        task = one.spec.tasks[number - 1]
        order = match(states.info["target"][i], task.goal_xyz)
        np.testing.assert_allclose(states.info["target"][i], task.goal_xyz[order], atol=1e-6)
        shift = positions[i] - task.start_xyz[order]
        np.testing.assert_allclose(shift[:, 2], 0, atol=1e-6)
        orders.append(order)
        shifts.append(shift[:, :2])
    assert np.abs(shifts).max() <= START_JITTER + 1e-6
    uniform = stats.uniform(-START_JITTER, 2 * START_JITTER)
    assert stats.kstest(np.ravel(shifts), uniform.cdf).pvalue > 1e-3
    yaws = np.mod(2 * np.arctan2(quats[..., 3], quats[..., 0]), 2 * np.pi)
    np.testing.assert_array_equal(quats[..., 1:3], 0)
    assert stats.kstest(yaws.ravel(), stats.uniform(0, 2 * np.pi).cdf).pvalue > 1e-3
    counts = np.bincount(np.array(orders)[:, 0], minlength=num_cubes)
    assert stats.chisquare(counts).pvalue > 1e-3


def match(points: np.ndarray, table: np.ndarray) -> np.ndarray:
    """Which row of the table each point is; every row once."""
    order = np.linalg.norm(points[:, None] - table, axis=-1).argmin(axis=1)
    assert sorted(order) == list(range(len(table)))
    return order


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
    reset_to = jax.jit(jax.vmap(one.reset_to, in_axes=(0, None, None)))
    states = reset_to(KEYS, start, goal)
    np.testing.assert_array_equal(states.info["task"], USER_TASK)
    np.testing.assert_allclose(states.info["target"], np.tile(goal, (BATCH, 1, 1)), atol=1e-6)
    shift = cubes(one, states.pipeline_state)[0] - start
    uniform = stats.uniform(-START_JITTER, 2 * START_JITTER)
    assert stats.kstest(shift[..., :2].ravel(), uniform.cdf).pvalue > 1e-3
    np.testing.assert_allclose(shift[..., 2], 0, atol=1e-6)


def test_reset_to_exact_poses(env):
    one = env("cube-double")
    start = np.array([[0.35, -0.1, 0.02], [0.5, 0.2, 0.02]])
    yaw = np.array([0.5, -2.0])
    state = jax.jit(partial(one.reset_to, yaw=yaw, jitter=0.0))(KEYS[0], start, start)
    positions, quats = cubes(one, state.pipeline_state)
    np.testing.assert_allclose(positions, start, atol=1e-7)
    turned = Rotation.from_quat(quats, scalar_first=True).as_matrix()
    expected = Rotation.from_euler("z", yaw[:, None]).as_matrix()
    np.testing.assert_allclose(turned, expected, atol=1e-6)


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


NEAR, FAR = 0.0399, 0.0401  # metres, either side of what counts as success
OFFSETS = np.array([[NEAR, -NEAR], [FAR, NEAR], [NEAR, -FAR], [0.1, 0.1], [0.0, 0.0]])
SUCCESS = [True, False, False, False, True]


@pytest.fixture(scope="module")
def off_target(env, started) -> State:
    """States at rest with the cubes OFFSETS off target in x."""
    one, count = env("cube-double"), len(OFFSETS)
    states = jax.tree.map(lambda x: x[:count], started("cube-double"))
    targets = np.tile([[0.4, -0.15, 0.02], [0.45, 0.15, 0.02]], (count, 1, 1))
    poses = np.concatenate([targets, np.tile([1.0, 0, 0, 0], (count, 2, 1))], axis=-1)
    poses[..., 0] += OFFSETS
    qpos = states.pipeline_state.qpos.at[:, one.scene.cubes_qpos].set(poses.reshape(count, 14))
    return states.replace(
        pipeline_state=states.pipeline_state.replace(qpos=qpos),
        info=states.info | {"target": jnp.float32(targets)},
    )


def test_success_is_every_cube_within_four_centimetres(env, step, off_target, ogbench_env):
    after = step("cube-double")(off_target, jnp.zeros((5, 5)))
    np.testing.assert_array_equal(after.info["success"], SUCCESS)
    for number in (after.reward, after.done, after.metrics["success"]):
        np.testing.assert_array_equal(number, np.float32(SUCCESS))
    # What OGBench says of the very same cubes.
    theirs = ogbench_env("cube-double", "task")
    positions, _ = cubes(env("cube-double"), after.pipeline_state)
    for row, success in enumerate(SUCCESS):
        for i in range(2):
            theirs.data.joint(f"object_joint_{i}").qpos[:3] = positions[row, i]
            target = theirs._cube_target_mocap_ids[i]
            theirs.data.mocap_pos[target] = after.info["target"][row, i]
        assert all(theirs._compute_successes()) == success


def test_a_state_that_is_done_stays_as_it_is(step, off_target):
    after = step("cube-double")(off_target, jnp.ones((5, 5)))
    again = step("cube-double")(after, -jnp.ones((5, 5)))
    for row, success in enumerate(SUCCESS):
        one, other = (bytes_of(jax.tree.map(lambda x, row=row: x[row], x)) for x in (after, again))
        assert (one == other) == success


@pytest.mark.parametrize("what", ["lost cube", "fast arm", "mad action"])
def test_divergence_ends_the_episode_as_a_failure(step, off_target, what):
    actions = jnp.zeros((5, 5))
    well = step("cube-double")(off_target, actions)
    physics_state = off_target.pipeline_state
    if what == "lost cube":
        physics_state = physics_state.replace(qpos=physics_state.qpos.at[4, 14].set(jnp.nan))
    elif what == "fast arm":
        physics_state = physics_state.replace(qvel=physics_state.qvel.at[4, 1].set(1e6))
    else:
        actions = actions.at[4].set(jnp.nan)
    after = step("cube-double")(off_target.replace(pipeline_state=physics_state), actions)
    np.testing.assert_array_equal(after.info["diverged"], [False] * 4 + [True])
    assert not after.info["success"][4]
    assert (after.done[4], after.reward[4], after.metrics["success"][4]) == (1, 0, 0)
    others = [jax.tree.map(lambda x: x[:4], states) for states in (after, well)]
    assert bytes_of(others[0]) == bytes_of(others[1])


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
