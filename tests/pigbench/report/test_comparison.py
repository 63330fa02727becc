import itertools

import numpy as np
import pytest
import scipy.stats

from pigbench.errors import UserError
from pigbench.report import comparison, stats
from pigbench.report.scoring import Scoring

# Successes of ten episodes of each of two tasks, by seed.
OUTCOMES = {
    ("gcivl", "cube-single"): [(3, 5), (6, 2), (4, 4)],
    ("gcivl", "cube-double"): [(1, 0), (2, 2), (0, 3)],
    ("qrl", "cube-single"): [(8, 9), (3, 5), (7, 7)],
    ("qrl", "cube-double"): [(0, 0), (2, 1), (4, 6)],
    ("qrl", "cube-triple"): [(10, 10)],
}


@pytest.fixture
def results(tmp_path, make_run):
    def episodes(successes):
        return [1] * successes + [0] * (10 - successes)

    return stats.read_results(
        make_run(
            tmp_path / f"{method}-{environment}-{seed}",
            {100: [episodes(successes) for successes in tasks]},
            method=method,
            environment=environment,
            seed=seed,
        )
        for (method, environment), seeds in OUTCOMES.items()
        for seed, tasks in enumerate(seeds)
    )


def rates(method, environment):
    """(seeds, tasks), in percent."""
    return 10.0 * np.array(OUTCOMES[method, environment])


def pool(results, scoring):
    return comparison.pool(comparison.common(scoring.cells(results)), scoring)


@pytest.mark.parametrize("over", ["environments", "tasks"])
def test_aggregates_are_over_what_all_methods_have(results, over):
    scoring = Scoring(over=over)
    pooled = pool(results, scoring)
    assert pooled.environments == ["cube-double", "cube-single"]
    aggregates = comparison.aggregated(pooled, scoring)
    for method in ("gcivl", "qrl"):
        both = np.concatenate([rates(method, "cube-single"), rates(method, "cube-double")])
        numbers = both.mean(axis=1) if over == "environments" else both.ravel()
        iqm, mean = aggregates[method, "IQM"], aggregates[method, "mean"]
        assert iqm.value == pytest.approx(scipy.stats.trim_mean(numbers, 0.25))
        assert mean.value == pytest.approx(numbers.mean())
        assert mean.seeds == 3
        # All 27 x 27 draws of seeds, equally likely, tell the interval of the mean.
        draws = itertools.product(itertools.product(range(3), repeat=3), repeat=2)
        means = [
            (
                rates(method, "cube-single")[list(one)].mean()
                + rates(method, "cube-double")[list(other)].mean()
            )
            / 2
            for one, other in draws
        ]
        assert mean.interval == pytest.approx(np.percentile(means, [2.5, 97.5]), abs=1.5)


def test_improvements_agree_with_mann_and_whitney(results):
    scoring = Scoring()
    pooled = pool(results, scoring)
    improvements = comparison.improvements(pooled, scoring)
    expected = np.mean(
        [
            scipy.stats.mannwhitneyu(
                rates("qrl", environment).mean(axis=1), rates("gcivl", environment).mean(axis=1)
            ).statistic
            / 9
            for environment in ("cube-single", "cube-double")
        ]
    )
    better = improvements["qrl", "gcivl"]
    assert better.value == pytest.approx(100 * expected)
    assert better.interval.low <= better.value <= better.interval.high
    worse = improvements["gcivl", "qrl"]
    assert worse.value == pytest.approx(100 - better.value)
    assert worse.interval is not None


def test_profiles_by_hand(results):
    scoring = Scoring()
    # qrl's runs: 85, 40 and 70 in one environment, 0, 15 and 50 in the other.
    profiles = comparison.profiles(pool(results, scoring), np.array([0.0, 40, 80]), scoring)
    share, band = profiles["qrl"]
    np.testing.assert_allclose(share, [500 / 6, 300 / 6, 100 / 6])
    assert (band[0] <= share).all()
    assert (share <= band[1]).all()


def test_the_order_of_results_does_not_matter(results):
    def everything(results):
        scoring = Scoring(over="tasks")
        pooled = pool(results, scoring)
        return comparison.aggregated(pooled, scoring), comparison.improvements(pooled, scoring)

    assert everything(results) == everything(results[::-1])


def test_methods_need_an_environment_in_common(results):
    apart = [
        result
        for result in results
        if (result.run.config.method == "gcivl") != (result.run.config.environment == "cube-triple")
    ]
    with pytest.raises(UserError, match="no environment has runs of all methods: gcivl, qrl"):
        pool(apart, Scoring())


def test_improvement_needs_two_methods(results):
    alone = [result for result in results if result.run.config.method == "qrl"]
    with pytest.raises(UserError, match="give runs of at least two"):
        comparison.improvements(pool(alone, Scoring()), Scoring())
