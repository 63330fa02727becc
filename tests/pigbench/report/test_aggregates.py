import numpy as np
import pytest
import scipy.stats

from pigbench.report import aggregates


def make_strata(*runs):
    generator = np.random.default_rng(3)
    return [generator.integers(11, size=(number, 5)) * 10.0 for number in runs]


@pytest.fixture
def strata():
    return make_strata(3, 4, 2)


@pytest.mark.parametrize("runs", [(1,), (3, 3), (2, 2, 2), (3, 3, 3)])
def test_pooled_measures_of_equally_many_runs_agree_with_scipy(runs):
    strata = make_strata(*runs)
    everything = np.concatenate([stratum.ravel() for stratum in strata])
    expected = scipy.stats.trim_mean(everything, 0.25)
    assert aggregates.interquartile_mean(strata) == pytest.approx(expected)
    assert aggregates.mean(strata) == pytest.approx(scipy.stats.tmean(everything))


def test_pooled_measures_of_other_numbers_of_runs_agree_with_scipy_on_repeated_runs(strata):
    even = [np.tile(stratum, (12 // len(stratum), 1)) for stratum in strata]
    everything = np.concatenate([stratum.ravel() for stratum in even])
    expected = scipy.stats.trim_mean(everything, 0.25)
    assert aggregates.interquartile_mean(strata) == pytest.approx(expected)
    assert aggregates.mean(strata) == pytest.approx(scipy.stats.tmean(everything))


@pytest.mark.parametrize("measure", [aggregates.mean, aggregates.interquartile_mean])
def test_environments_weigh_the_same_however_many_runs_they_have(measure):
    good, bad = np.array([[80.0]]), np.array([[0.0]])
    for runs in ((1, 1), (3, 1), (1, 3), (5, 3)):
        strata = [np.tile(one, (many, 1)) for one, many in zip((good, bad), runs, strict=True)]
        assert measure(strata) == pytest.approx(40)


def test_the_interquartile_mean_by_hand():
    # Of 0, 1, 2, 3, 4, 5, 6, 100 the lowest and the highest two go: (2 + 3 + 4 + 5) / 4.
    strata = [np.array([[100.0, 0], [4, 5]]), np.array([[6.0, 1], [2, 3]])]
    assert aggregates.interquartile_mean(strata) == 3.5
    assert aggregates.mean(strata) == 121 / 8


def test_the_probability_of_improvement_is_mann_and_whitneys_u(strata):
    second = [np.flip(stratum, axis=0)[:2] + 10 for stratum in strata]
    shares = [
        scipy.stats.mannwhitneyu(ours[:, task], theirs[:, task]).statistic
        / (len(ours) * len(theirs))
        for ours, theirs in zip(strata, second, strict=True)
        for task in range(5)
    ]
    probability = aggregates.probability_of_improvement(strata, second)
    assert probability == pytest.approx(np.mean(shares))
    assert aggregates.probability_of_improvement(second, strata) == pytest.approx(1 - probability)


def test_the_probability_of_improvement_by_hand():
    # Pairs (1, 1), (1, 0), (3, 1), (3, 0): a tie and three wins; in the other environment a loss.
    first = [np.array([[1.0], [3.0]]), np.array([[0.0]])]
    second = [np.array([[1.0], [0.0]]), np.array([[5.0]])]
    assert aggregates.probability_of_improvement(first, second) == (3.5 / 4 + 0) / 2


def test_the_profile_agrees_with_scipys_distribution_function():
    values = np.array([10.0, 10, 40, 90])
    thresholds = np.array([0.0, 10, 39, 90])
    expected = scipy.stats.ecdf(values).sf.evaluate(thresholds)
    np.testing.assert_allclose(aggregates.profile([values[:, None]], thresholds), expected)


def test_environments_weigh_the_same_in_a_profile():
    strata = [np.array([[60.0], [60], [60]]), np.array([[20.0]])]
    np.testing.assert_allclose(aggregates.profile(strata, np.array([50.0])), [0.5])


@pytest.mark.parametrize("measure", [aggregates.mean, aggregates.interquartile_mean])
def test_leading_axes_are_kept(strata, measure):
    many = [np.stack([stratum, 2 * stratum]) for stratum in strata]
    np.testing.assert_allclose(measure(many), [measure(strata), 2 * measure(strata)])
