"""Results whose success rates are given."""

import pytest

from pigbench.report import stats


@pytest.fixture
def make_results(tmp_path, make_run):
    """`make_results({(method, environment): [...]})`, one run a seed.

    A run is {step: [percent on task 1, percent on task 2, ...]}, in whole tens. Keywords change the
    runs' configuration.
    """

    def make(rates, **changes):
        return stats.read_results(
            make_run(
                tmp_path / f"{method}-{changes.get('variant', '')}" / environment / str(seed),
                {
                    step: [[1] * (percent // 10) + [0] * (10 - percent // 10) for percent in tasks]
                    for step, tasks in curve.items()
                },
                method=method,
                environment=environment,
                seed=seed,
                **changes,
            )
            for (method, environment), seeds in rates.items()
            for seed, curve in enumerate(seeds)
        )

    return make
