"""The statistics of estimates, by SciPy, and poses by its rotations."""

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy import stats
from scipy.spatial.transform import Rotation

from pigbench.envs.physics import PhysicsState
from pigbench.envs.reality import PoseEstimate, estimate

COUNT = 400
POSE = np.array(
    [0.4, -0.1, 0.02, *Rotation.from_euler("xyz", [0.3, -0.2, 1.1]).as_quat()[[3, 0, 1, 2]]]
)


@pytest.fixture(scope="module")
def state(scene):
    built = scene(1)
    qpos = jnp.asarray(built.home_qpos, jnp.float32).at[built.cubes_qpos].set(POSE)
    zero = jnp.zeros(())
    return PhysicsState(
        qpos=qpos,
        qvel=jnp.zeros(built.model.nv),
        warmstart=jnp.zeros(built.model.nv),
        pinch_pos=jnp.array([0.4, -0.1, 0.3]),
        pinch_yaw=zero,
        pad_force=zero,
        diverged=zero > 0,
        overflow=zero > 0,
    )


def track(scene, model, states):
    """What is known of the cube over the steps of each of COUNT episodes: (COUNT, steps + 1, 7)."""

    def episode(key):
        first, *keys = jax.random.split(key, len(states) + 1)
        now = estimate.begin(first, model, scene(1), states[0])
        known = [now.known]
        for key, state in zip(keys, states, strict=True):
            now = estimate.advance(key, model, scene(1), now, state)
            known.append(now.known)
        return jnp.stack(known)[:, 0]

    return np.asarray(jax.jit(jax.vmap(episode))(jax.random.split(jax.random.key(0), COUNT)), float)


def moved(scene, state, x):
    """The state with the cube at that x."""
    place = scene(1).cubes_qpos.start
    return replace(state, qpos=state.qpos.at[place].set(x))


def yaw_errors(known):
    truth = Rotation.from_quat(POSE[[4, 5, 6, 3]])
    turns = Rotation.from_quat(known[..., [4, 5, 6, 3]].reshape(-1, 4)) * truth.inv()
    vectors = turns.as_rotvec().reshape(*known.shape[:-1], 3)
    np.testing.assert_allclose(vectors[..., :2], 0, atol=1e-5)  # about the vertical alone
    return vectors[..., 2]


def test_noise_is_new_in_every_frame(scene, state):
    model = PoseEstimate(position_noise=0.01, yaw_noise=0.1)
    known = track(scene, model, [state] * 3)
    errors = (known[..., :3] - POSE[:3]) / 0.01
    assert stats.kstest(errors.ravel(), "norm").pvalue > 1e-3
    assert stats.kstest((yaw_errors(known) / 0.1).ravel(), "norm").pvalue > 1e-3
    assert abs(np.corrcoef(errors[:, 0, 0], errors[:, 1, 0])[0, 1]) < 0.2


def test_bias_lasts_an_episode(scene, state):
    known = track(scene, PoseEstimate(position_bias=0.01, yaw_bias=0.1), [state] * 2)
    np.testing.assert_allclose(known[:, 1:], known[:, :1].repeat(2, axis=1), atol=1e-6)
    assert stats.kstest(((known[:, 0, :3] - POSE[:3]) / 0.01).ravel(), "norm").pvalue > 1e-3
    assert stats.kstest(yaw_errors(known[:, 0]) / 0.1, "norm").pvalue > 1e-3


def test_a_track_may_begin_at_a_wrong_pose(scene, state):
    model = PoseEstimate(misregistration=0.3, misregistration_bias=0.05)
    errors = track(scene, model, [state])[:, 0, :3] - POSE[:3]
    wrong = np.abs(errors).max(axis=-1) > 1e-6
    assert stats.binomtest(int(wrong.sum()), COUNT, 0.3).pvalue > 1e-3
    assert stats.kstest((errors[wrong] / 0.05).ravel(), "norm").pvalue > 1e-3


def test_latency_is_in_control_steps(scene, state):
    states = [moved(scene, state, x) for x in (0.3, 0.4, 0.5, 0.6)]
    known = track(scene, PoseEstimate(latency=2), states)
    np.testing.assert_allclose(known[0, :, 0], [0.3, 0.3, 0.3, 0.3, 0.4], atol=1e-6)


@pytest.mark.parametrize(("pinch_height", "lost"), [(0.3, 0.1), (0.04, 0.6)])
def test_a_lost_frame_leaves_the_estimate(scene, state, pinch_height, lost):
    model = PoseEstimate(dropout=0.1, occlusion_distance=0.05, occluded_dropout=0.6)
    state = replace(state, pinch_pos=state.pinch_pos.at[2].set(pinch_height))
    known = track(scene, model, [state, moved(scene, state, 0.41)])
    stays = np.isclose(known[:, 2, 0], POSE[0])
    np.testing.assert_allclose(known[~stays, 2, 0], 0.41, atol=1e-6)
    assert stats.binomtest(int(stays.sum()), COUNT, lost).pvalue > 1e-3


def test_zero_is_the_pose_itself(scene, state):
    known = partial(track, scene)(PoseEstimate(), [state] * 2)
    np.testing.assert_array_equal(known, np.broadcast_to(np.float32(POSE), known.shape))
