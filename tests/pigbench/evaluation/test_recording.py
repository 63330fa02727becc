"""Recorded episodes are those of the evaluation, and replay in the environment."""

from types import SimpleNamespace

import jax.numpy as jnp
import numpy as np
import pytest

from pigbench.evaluation import recording as module
from pigbench.evaluation.recording import make_recorder
from pigbench.evaluation.rollouts import make_evaluator
from pigbench.evaluation.settings import Evaluation


def test_the_evaluations_episodes(env, drawn, monkeypatch):
    monkeypatch.setattr(module, "_CHUNK", 4)  # no divisor of the limit
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


@pytest.mark.parametrize(("limit", "success"), [(130, False), (150, True)])
def test_what_comes_after_the_limit_is_no_success(limit, success):
    def after(time):
        placed = np.array([time >= 140])
        return SimpleNamespace(
            time=time,
            values={"length": np.array([min(time, 140)])},
            states=SimpleNamespace(
                done=placed,
                info={"success": placed, "task": np.array([1]), "target": np.zeros((1, 1, 3))},
                pipeline_state=SimpleNamespace(qpos=jnp.full((1, 2), float(time))),
            ),
        )

    def advance(_, rollout, *, steps):
        times = rollout.time + 1 + np.arange(steps)
        return after(rollout.time + steps), np.tile(times[:, None, None], (1, 1, 2))

    _, (one,) = module._record(lambda _: after(0), advance, limit, None, lambda _: None)
    assert one.success == success
    assert [qpos[0] for qpos in one.qpos] == list(range(min(limit, 140) + 1))
