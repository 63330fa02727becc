import numpy as np
import pytest
import scipy.stats

from pigbench.report import aggregates, bootstrap


def column(*values):
    return np.array(values, float)[:, None]


def test_two_runs_by_hand():
    # Of two runs, the mean is the lower, their middle or the upper one with 1/4, 1/2 and 1/4.
    assert bootstrap.interval([column(10, 30)], aggregates.mean, seed=0) == (10, 30)


def test_strata_are_drawn_apart_by_hand():
    # Means of two strata of 0 and 100: the ends 0 and 100 have 1/16 each, more than 2.5 %. Of four
    # strata the ends have 1/256 and the next, 12.5 and 87.5, 8/256: together 3.5 %.
    assert bootstrap.interval([column(0, 100)] * 2, aggregates.mean, seed=0) == (0, 100)
    assert bootstrap.interval([column(0, 100)] * 4, aggregates.mean, seed=0) == (12.5, 87.5)
    # A stratum's own runs only: the mean of any draw is between 5 and 95.
    apart = [column(0, 10), column(90, 100)]
    assert bootstrap.interval(apart, aggregates.mean, seed=0) == (45, 55)


def test_agrees_with_scipy_on_one_stratum():
    values = np.random.default_rng(5).normal(50, 20, size=30)
    ours = bootstrap.interval([values[:, None]], aggregates.mean, seed=0)
    theirs = scipy.stats.bootstrap(
        (values,), np.mean, n_resamples=9999, method="percentile", rng=np.random.default_rng(1)
    ).confidence_interval
    # The mean's standard error is near 3.7, and 2000 draws know its 2.5 % point to within 0.3.
    assert ours == pytest.approx((theirs.low, theirs.high), abs=0.8)


def test_a_run_keeps_its_numbers_together():
    # What a run lacks on one task it has on the other: its mean is 50 in every draw.
    tasks = np.array([[0.0, 100.0], [100.0, 0.0], [30.0, 70.0]])
    assert bootstrap.interval([tasks], aggregates.mean, seed=0) == (50, 50)


def test_a_stratum_of_one_run_has_no_interval():
    assert bootstrap.interval([column(1, 2), column(3)], aggregates.mean, seed=0) is None


def test_the_seed_decides():
    values = [np.random.default_rng(0).normal(size=(7, 1))]
    first, again, other = (
        bootstrap.interval(values, aggregates.mean, seed=seed) for seed in (0, 0, 1)
    )
    assert first == again != other


def test_a_band_holds_an_interval_of_each_number():
    strata = [column(0, 100)]

    def both(drawn):
        mean = aggregates.mean(drawn)
        return np.stack([mean, -mean], axis=-1)

    np.testing.assert_array_equal(bootstrap.band(strata, both, seed=0), [[0, -100], [100, 0]])
