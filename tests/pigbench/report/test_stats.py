import numpy as np
import pytest
import scipy.stats

from pigbench.errors import UserError
from pigbench.report import stats
from pigbench.report.stats import Estimate
from pigbench.training import run as runs


def test_estimate_agrees_with_scipy():
    values = [12.0, 40.0, 35.5, 20.0]
    mean, deviation, seeds = stats.estimate(values)
    assert mean == pytest.approx(scipy.stats.tmean(values))
    assert deviation == pytest.approx(scipy.stats.tstd(values))
    assert seeds == 4


def test_one_seed_has_no_deviation():
    assert stats.estimate([40.0]) == Estimate(40.0, None, 1)


def test_the_seed_is_the_unit_and_the_last_step_counts(tmp_path, make_run):
    # Final rates by hand: 3 of 4 and 1 of 4 episodes, so 75 % and 25 %: mean 50, deviation
    # sqrt((25² + 25²) / 1) = 35.36.
    made = [
        make_run(tmp_path / "0", {100: [[0, 0], [0, 0]], 200: [[1, 1], [0, 1]]}, seed=0),
        make_run(tmp_path / "1", {100: [[1, 1], [0, 0]], 200: [[0, 0], [0, 1]]}, seed=1),
    ]
    results = stats.read_results(made)
    assert stats.final_success(results) == (50, pytest.approx(np.sqrt(1250)), 2)
    assert stats.final_task_success(results) == {
        (1, "task1"): (50, pytest.approx(np.sqrt(5000)), 2),
        (2, "task2"): (50, 0, 2),
    }
    assert stats.success_curve(results) == {
        100: (25, pytest.approx(np.sqrt(1250)), 2),
        200: (50, pytest.approx(np.sqrt(1250)), 2),
    }


def test_results_are_grouped_by_method_and_environment(tmp_path, make_run):
    made = [
        make_run(tmp_path / "a", {1: [[1]]}),
        make_run(tmp_path / "b", {1: [[1]]}, seed=1),
        make_run(tmp_path / "c", {1: [[1]]}, method="qrl", agent={"margin": 0.05}),
        make_run(tmp_path / "d", {1: [[1]]}, environment="cube-double"),
    ]
    grouped = stats.cells(stats.read_results(made))
    names = {cell: [result.run.path.name for result in group] for cell, group in grouped.items()}
    assert names == {
        ("gcivl", "cube-single"): ["a", "b"],
        ("qrl", "cube-single"): ["c"],
        ("gcivl", "cube-double"): ["d"],
    }


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"seed": 1, "preset": "paper"}, "preset is 'cpu' in one and 'paper' in the other"),
        ({"seed": 1, "dataset_digest": "cd"}, "dataset_digest is"),
        ({"seed": 0}, "have the same seed"),
        ({"method": "qrl", "physics": "fast"}, "physics is 'exact' in one and 'fast'"),
    ],
)
def test_runs_that_cannot_be_compared_are_named(tmp_path, make_run, changes, message):
    made = [
        make_run(tmp_path / "first", {1: [[1]]}),
        make_run(tmp_path / "second", {1: [[1]]}, **changes),
    ]
    with pytest.raises(UserError, match=f"first and .*second .*{message}"):
        stats.cells(stats.read_results(made))


def test_an_unfinished_run_is_not_averaged_with_a_finished_one(tmp_path, make_run):
    made = [
        make_run(tmp_path / "done", {100: [[1]], 200: [[1]]}, seed=0),
        make_run(tmp_path / "half", {100: [[0]]}, seed=1),
    ]
    results = stats.read_results(made)
    with pytest.raises(UserError, match="last evaluated step is 200 in one and 100 in the other"):
        stats.final_success(results)
    assert stats.success_curve(results) == {100: (50, pytest.approx(np.sqrt(5000)), 2)}


def test_runs_without_an_evaluation_are_all_named(tmp_path, config, make_run):
    made = [
        make_run(tmp_path / "done", {1: [[1]]}),
        runs.open_run(tmp_path / "new", config, {}),
        make_run(tmp_path / "empty", {}),
    ]
    with pytest.raises(UserError, match=r"no evaluation yet in \S*/new, \S*/empty; use"):
        stats.read_results(made)
