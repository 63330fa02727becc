import numpy as np
import pytest

from pigbench.agents import Statistics
from pigbench.errors import UserError
from pigbench.runs import run as runs
from pigbench.runs.statistics import read_statistics
from pigbench.support import files

STATISTICS = Statistics(np.array([0.1, -2.5], np.float32), np.array([1 / 3, 0.02], np.float32))


def test_statistics_are_kept_to_the_bit(tmp_path, config):
    run = runs.open_run(tmp_path, config, {}, STATISTICS)
    kept = read_statistics(run.statistics_path)
    for ours, theirs in zip(kept, STATISTICS, strict=True):
        assert ours.dtype == np.float32
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("content", [{"mean": [1.0]}, {"mean": "x", "deviation": "y"}])
def test_torn_statistics_are_named(tmp_path, config, content):
    run = runs.open_run(tmp_path, config, {}, STATISTICS)
    files.write_sealed(run.statistics_path, content)
    with pytest.raises(UserError, match=r"statistics\.json is torn"):
        read_statistics(run.statistics_path)
