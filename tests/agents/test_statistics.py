import jax.numpy as jnp
import numpy as np
import pytest

from pigbench.agents import statistics
from pigbench.agents.statistics import DEVIATION_FLOOR, Statistics
from pigbench.errors import UserError


def test_mean_and_deviation_by_hand_and_a_floor_where_nothing_moves():
    rows = jnp.array([[0.0, 10.0, 5.0], [2.0, 20.0, 5.0], [4.0, 30.0, 5.001]])
    mean, deviation = Statistics.of(rows)
    np.testing.assert_allclose(mean, [2, 20, 5.000333], rtol=1e-6)
    np.testing.assert_allclose(deviation, [np.sqrt(8 / 3), 10 * np.sqrt(2 / 3), DEVIATION_FLOOR])


def test_of_very_many_rows_evenly_spaced_ones_are_taken(monkeypatch):
    monkeypatch.setattr(statistics, "_ROWS", 3)
    mean, _ = Statistics.of(np.arange(7.0)[:, None])
    assert mean == pytest.approx([3])  # rows 0, 3, 6


def test_single_precision_sums_do_not_blur_a_small_deviation():
    rows = 1000 + np.tile([[-0.5], [0.5]], (500_000, 1)).astype(np.float32)
    mean, deviation = Statistics.of(rows)
    assert mean == pytest.approx([1000], rel=1e-7)
    assert deviation == pytest.approx([0.5], rel=1e-5)


def test_terms_are_selected_in_their_order():
    all_terms = Statistics(np.arange(6.0), np.arange(6.0) + 10)
    mean, deviation = all_terms.select({"a": slice(4, 6), "b": slice(0, 1)})
    assert mean.tolist() == [4, 5, 0]
    assert deviation.tolist() == [14, 15, 10]


def test_what_needs_statistics_says_so():
    with pytest.raises(UserError, match="standardize needs the statistics of a data set"):
        statistics.require_statistics(None, "standardize")
