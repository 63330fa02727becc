from types import SimpleNamespace

import numpy as np
import pytest

from pigbench.analysis.subgoals import draw
from pigbench.errors import UserError

STEPS = 2


@pytest.fixture
def split():
    """Episodes of 6, 4 and 5 rows, numbered; the second has not twice 2 transitions."""
    numbers = np.arange(15)
    ends = np.isin(numbers, [5, 9, 14])
    column = numbers[:, None].astype(np.float32)
    fields = {
        "terminals": ends,
        "observations": column,
        "qpos": 100 + column,
        "qvel": 200 + column,
        "actions": 300 + column,
    }
    return SimpleNamespace(folder="data", concatenate=fields.__getitem__)


def test_stretches_stay_within_their_episodes(split):
    stretches = draw(split, STEPS, samples=200, seed=0)
    assert set(stretches.starts.ravel()) == {0, 1, 10}
    np.testing.assert_array_equal(stretches.qpos, stretches.starts + 100)
    np.testing.assert_array_equal(stretches.qvel, stretches.starts + 200)
    steps = np.arange(STEPS)[:, None, None]
    np.testing.assert_array_equal(stretches.ahead, stretches.starts + STEPS + steps)
    np.testing.assert_array_equal(stretches.actions, 300 + stretches.starts + steps)


def test_episodes_may_be_too_short(split):
    with pytest.raises(UserError, match="data has no episode of 6 transitions, twice K"):
        draw(split, 3, samples=1, seed=0)
