"""Recordings: what is in them, and that they follow from their seed."""

import numpy as np
import pytest

from pigbench.errors import UserError
from pigbench.fidelity import peer, recording


def test_states_actions_and_sub_tasks(recordings):
    (one,) = recordings
    steps = len(one.actions)
    assert one.actions.shape == (300, 5)
    assert np.abs(one.actions).max() <= 1
    assert one.qpos.shape == (steps + 1, 28)
    assert one.qvel.shape == (steps + 1, 26)
    assert one.observations.shape == (steps, 37)
    assert one.contact.shape == one.opening.shape == one.pinch_yaw.shape == (steps + 1,)
    # A sub-task takes about 90 control steps, and moves its cube to its target.
    ends = np.flatnonzero(one.ended)
    assert 2 <= len(ends) <= 4
    assert one.success[ends].any()
    cube = one.cube[ends[0]]
    place = one.qpos[ends[0] + 1, 14 + 7 * cube : 17 + 7 * cube]
    assert one.success[ends[0]] == (np.linalg.norm(place - one.target[ends[0]]) <= 0.04)
    assert one.cube[ends[0] + 1] in (0, 1)


def test_what_is_recorded_is_what_the_environment_saw(recordings):
    (one,) = recordings
    np.testing.assert_allclose(one.observations[:, :6], one.qpos[:-1, :6])
    pinch = one.observations[:, 12:15] / 10 + [0.425, 0, 0]
    np.testing.assert_allclose(pinch, one.pinch_pos[:-1], atol=1e-12)
    np.testing.assert_allclose(one.observations[:, 18], one.contact[:-1])


def test_the_seed_decides():
    def record(seed: int):
        return recording.record("cube-single", "noisy", episodes=1, steps=30, seed=seed)[0]

    one, same, other = record(1), record(1), record(2)
    for field, again in zip(one, same, strict=True):
        np.testing.assert_array_equal(field, again)
    assert not np.array_equal(one.actions, other.actions)


def test_numpys_own_stream_is_put_back():
    np.random.seed(5)
    expected = np.random.random(3)
    np.random.seed(5)
    with peer.numpy_seed(1):
        np.random.random(7)
    np.testing.assert_array_equal(np.random.random(3), expected)


def test_progress_is_reported():
    done = []
    recording.record("cube-single", "play", episodes=2, steps=130, seed=0, report=done.append)
    assert sum(done) == 260


def test_an_unknown_policy_offers_the_nearest():
    with pytest.raises(UserError, match="did you mean 'play'"):
        recording.record("cube-single", "paly", episodes=1, steps=1, seed=0)
