"""Quantities of data by hand, and the comparison against SciPy."""

import numpy as np
import pytest
from scipy import stats

from pigbench import envs
from pigbench.fidelity import distributions
from pigbench.fidelity.distributions import QUANTITIES, ScriptedEpisode


def episode(steps: int = 4, **changes: np.ndarray) -> ScriptedEpisode:
    still = ScriptedEpisode(
        cubes=np.tile([[0.3, 0, 0.02], [0.4, 0, 0.02]], (steps, 1, 1)),
        pinch=np.tile([0.4, 0.0, 0.2], (steps, 1)),
        contact=np.zeros(steps),
        actions=np.zeros((steps, 5)),
        ended=np.zeros(steps, bool),
        success=np.zeros(steps, bool),
    )
    return still._replace(**changes)


def values(name: str, one: ScriptedEpisode) -> np.ndarray:
    (quantity,) = (function for key, function in QUANTITIES.items() if name in key)
    return np.asarray(quantity(one), float)


def test_a_cube_lies_on_another_when_it_is_right_above_it():
    cubes = np.tile([[0.3, 0, 0.02], [0.4, 0, 0.02]], (4, 1, 1))
    cubes[1, 1] = [0.31, 0, 0.06]  # a centimetre off centre
    cubes[2, 1] = [0.325, 0, 0.06]  # beside it
    cubes[3, 1] = [0.3, 0, 0.1]  # carried above it
    np.testing.assert_array_equal(values("on another", episode(cubes=cubes)), [0, 1, 0, 0])
    np.testing.assert_allclose(values("highest", episode(cubes=cubes)), [0.02, 0.06, 0.06, 0.1])


def test_sub_tasks():
    one = episode(
        steps=6,
        ended=np.array([0, 0, 1, 0, 1, 0], bool),
        success=np.array([0, 1, 1, 1, 0, 0], bool),
    )
    np.testing.assert_array_equal(values("duration", one), [3, 2])
    np.testing.assert_array_equal(values("success", one), [1, 0])


def test_actions_and_touches():
    actions = np.array([[3, 0, 4, -2, 0], [0, 0, 0, 0, -1]]) / 10
    one = episode(steps=2, actions=actions, contact=np.array([0.0, 0.3]))
    np.testing.assert_allclose(values("move", one), [0.5, 0])
    np.testing.assert_allclose(values("yaw", one), [0.2, 0])
    np.testing.assert_allclose(values("gripper's", one), [0, 0.1])
    np.testing.assert_array_equal(values("touches", one), [0, 1])


def test_coverage_counts_cells_of_five_centimetres():
    # 7 x 14 x 7 cells; the third place is in the same cell as the first, the last outside.
    pinch = np.array(
        [[0.26, 0.01, 0.03], [0.34, 0.01, 0.03], [0.29, 0.04, 0.06], [0.9, 0.01, 0.03]]
    )
    assert values("visited", episode(pinch=pinch)) == pytest.approx(3 / (7 * 14 * 7))


def test_episodes_are_the_units_of_the_comparison():
    rng = np.random.default_rng(0)
    theirs, ours = (
        [episode(actions=rng.normal(size=(4, 5)) * scale) for _ in range(12)]
        for scale in (1.0, 1.5)
    )
    found = distributions.compare(theirs, ours)
    name = "size of the yaw's action"
    one, other = ([np.abs(e.actions[:, 3]).mean() for e in episodes] for episodes in (theirs, ours))
    expected = stats.ks_2samp(one, other)
    assert found[name] == pytest.approx(
        (np.mean(one), np.mean(other), expected.statistic, expected.pvalue)
    )
    assert "a cube on another" not in found  # it never varies here


def test_our_episodes():
    env = envs.make("cube-single", profile="fast")
    episodes = distributions.simulate(env, "play", episodes=2, steps=200, seed=0)
    assert len(episodes) == 2
    for one in episodes:
        assert one.cubes.shape == (200, 1, 3)
        assert 1 <= one.ended.sum() <= 4
        assert one.success[one.ended].all()
        assert one.contact.max() > 0.1
    assert not np.array_equal(episodes[0].actions, episodes[1].actions)
