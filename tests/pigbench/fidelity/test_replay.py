"""Replay: errors by hand, and a recording of OGBench's played again."""

import numpy as np
import pytest

from pigbench import envs
from pigbench.envs.contact import CARRYING, FREE, TOUCHING
from pigbench.fidelity import replay
from pigbench.fidelity.replay import SceneMotion


def motion(**changes: np.ndarray) -> SceneMotion:
    """Two control steps of one simulation of two cubes, at rest in the origin."""
    still = SceneMotion(
        pinch_pos=np.zeros((2, 1, 3)),
        opening=np.zeros((2, 1)),
        contact=np.zeros((2, 1)),
        cube_pos=np.zeros((2, 1, 2, 3)),
        cube_quat=np.broadcast_to([1.0, 0, 0, 0], (2, 1, 2, 4)),
    )
    return still._replace(**changes)


def test_errors_by_hand():
    cubes = np.zeros((2, 1, 2, 3))
    cubes[1, 0, 0], cubes[1, 0, 1] = [0.003, 0, 0.004], [0, 0.001, 0]
    quats = np.tile([1.0, 0, 0, 0], (2, 1, 2, 1))
    quats[0, 0, 1] = [-1, 0, 0, 0]  # the same orientation
    quats[1, 0, 1] = [np.cos(0.15), 0, 0, np.sin(0.15)]  # turned by 0.3 rad
    other = motion(
        pinch_pos=np.array([[[0, 0, 0]], [[0.0, 0.02, 0]]]),
        opening=np.array([[0], [-0.25]]),
        contact=np.array([[0.5], [0]]),
        cube_pos=cubes,
        cube_quat=quats,
    )
    errors = replay._errors(motion(), other)
    np.testing.assert_allclose(errors.pinch[:, 0], [0, 0.02])
    np.testing.assert_allclose(errors.opening[:, 0], [0, 0.25])
    np.testing.assert_allclose(errors.contact[:, 0], [0.5, 0])
    np.testing.assert_allclose(errors.cube[:, 0], [0, 0.005])
    np.testing.assert_allclose(errors.turn[:, 0], [0, 0.3], atol=1e-12)


def test_situations_are_of_all_steps_so_far():
    contact = np.array([[0, 0, 0.2], [0.2, 0, 0.2]])
    cubes = np.zeros((2, 3, 1, 3))
    cubes[1, :, 0, 2] = 0.06
    seen = replay._situations(
        SceneMotion(np.zeros((2, 3, 3)), contact, contact, cubes, np.zeros((2, 3, 1, 4)))
    )
    np.testing.assert_array_equal(seen, [[FREE, FREE, TOUCHING], [CARRYING, FREE, CARRYING]])


@pytest.mark.parametrize(("profile", "bound"), [("exact", 1e-5), ("fast", 1e-3)])
def test_a_recording_of_ogbenchs_comes_out_as_it_did(recordings, profile, bound):
    env = envs.make("cube-double", profile=profile)
    windows = replay.windows(env, recordings)
    assert windows.errors.cube.shape == windows.situations.shape == (50, 6)
    assert {CARRYING, FREE} <= set(windows.situations[9])
    print(f"{profile}: median {np.median(windows.errors.cube[-1]):.1e} m")
    assert np.median(windows.errors.cube[-1]) < bound
    assert np.median(windows.errors.pinch[-1]) < bound


def test_sub_tasks_end_as_they_did(recordings):
    outcomes = replay.outcomes(envs.make("cube-double"), recordings)
    assert len(outcomes.grasped) == recordings[0].ended.sum()
    ends = recordings[0].ended
    np.testing.assert_array_equal(outcomes.placed, recordings[0].success[ends])
    np.testing.assert_array_equal(outcomes.grasped_here, outcomes.grasped)
    np.testing.assert_array_equal(outcomes.placed_here, outcomes.placed)
    assert outcomes.grasped.all()
