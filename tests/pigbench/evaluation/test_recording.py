"""Recorded episodes are those of the evaluation, and replay in the environment."""

import numpy as np

from pigbench.evaluation import rollouts
from pigbench.evaluation.recording import make_recorder
from pigbench.evaluation.rollouts import make_evaluator
from pigbench.evaluation.settings import Evaluation


def test_the_evaluations_episodes(env, drawn, monkeypatch):
    monkeypatch.setattr(rollouts, "_CHUNK", 4)  # no divisor of the limit
    evaluation = Evaluation(episodes=2, seed=3)
    outcome = make_evaluator(env, drawn, evaluation)(None, print)
    reports = []
    recorded, recordings = make_recorder(env, drawn, evaluation)(None, reports.append)
    for name, values in outcome.items():
        np.testing.assert_array_equal(recorded[name], values)
    assert [recording.task for recording in recordings] == [1, 1, 2, 2]
    assert [recording.success for recording in recordings] == list(outcome["success"].ravel())
    steps = [len(recording.qpos) - 1 for recording in recordings]
    assert steps == list(outcome["length"].ravel()) == [1, 1, 6, 6]
    assert reports == [4, 6]
    for recording in recordings:
        target = 0.0 if recording.task == 1 else -0.2
        np.testing.assert_allclose(recording.target, [[0.4, target, 0.02]], atol=1e-6)
        cube = recording.qpos[0, 14:17]  # the start is jittered by 1 cm
        np.testing.assert_allclose(
            cube, [0.4, 0.0 if recording.task == 1 else 0.2, 0.02], atol=0.011
        )
        # The arm moves with every step, and no pose comes twice.
        assert np.all(np.abs(np.diff(recording.qpos[:, :6], axis=0)).max(axis=1) > 1e-3)
    assert not np.array_equal(recordings[2].qpos, recordings[3].qpos)
