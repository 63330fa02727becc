import contextlib

import numpy as np
import pytest
import scipy.stats

from pigbench.agents import Statistics
from pigbench.errors import UserError
from pigbench.evaluation import episodes
from pigbench.evaluation.episodes import Episode
from pigbench.report import stats
from pigbench.report.stats import Estimate
from pigbench.runs import run as runs


def test_estimate_agrees_with_scipy():
    values = [12.0, 40.0, 35.5, 20.0]
    estimate = stats.estimate(values)
    assert estimate.value == pytest.approx(scipy.stats.tmean(values))
    assert estimate.deviation == pytest.approx(scipy.stats.tstd(values))
    assert estimate.seeds == 4


def test_one_seed_has_no_deviation():
    assert stats.estimate([40.0]) == Estimate(40.0, None, None, 1)


def test_the_seed_is_the_unit(tmp_path, make_run):
    # At step 200, 3 of 4 and 1 of 4 episodes: 75 % and 25 %, mean 50 and deviation
    # sqrt((25² + 25²) / 1) = 35.36. Step 150 is not everyone's.
    made = [
        make_run(tmp_path / "0", {100: [[0, 0], [0, 0]], 200: [[1, 1], [0, 1]]}, seed=0),
        make_run(
            tmp_path / "1",
            {100: [[1, 1], [0, 0]], 150: [[1, 1], [1, 1]], 200: [[0, 0], [0, 1]]},
            seed=1,
        ),
    ]
    deviation = pytest.approx(np.sqrt(1250))
    assert stats.success_curve(stats.read_results(made)) == {
        100: (25, deviation, None, 2),
        200: (50, deviation, None, 2),
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


@pytest.mark.parametrize(
    ("again", "changes", "message"),
    [
        ([[1], [1]], {}, r"episodes per task at step 200 is \[2\] in one and \[1\] in the other"),
        ([[1, 1], [1, 1]], {"seed": 8}, r"evaluation seed at step 200 is \[7\] in one and \[8\]"),
        (
            [[1, 1], [1, 1]],
            {"engine": "mjx-warp"},
            r"engine at step 200 is \['mujoco'\] in one and \['mjx-warp'\]",
        ),
        ([[1, 1], [1, 1]], {}, None),
    ],
)
def test_unequal_evaluations_are_not_averaged(tmp_path, make_run, again, changes, message):
    curve = {100: [[0, 0], [0, 0]], 200: [[1, 1], [0, 1]]}
    made = [make_run(tmp_path / str(number), curve, seed=number) for number in (0, 1)]
    episodes.record(
        made[1].episodes_path,
        [
            Episode(
                200, task, f"task{task}", number, 7, "mujoco", {"success": bool(success)}
            )._replace(**changes)
            for task, successes in enumerate(again, start=1)
            for number, success in enumerate(successes)
        ],
    )
    refused = pytest.raises(UserError, match=message) if message else contextlib.nullcontext()
    with refused:
        stats.cells(stats.read_results(made))


def test_seeds_are_in_order_whatever_the_order_of_runs(tmp_path, make_run):
    made = [make_run(tmp_path / str(seed), {1: [[1]]}, seed=seed) for seed in (2, 0, 1)]
    (group,) = stats.cells(stats.read_results(made)).values()
    assert [result.run.config.seed for result in group] == [0, 1, 2]


def test_a_variant_is_a_method_of_its_own(tmp_path, make_run):
    made = [
        make_run(tmp_path / "plain", {1: [[1]]}),
        make_run(tmp_path / "sharp", {1: [[1]]}, variant="sharp", agent={"temperature": 20.0}),
    ]
    names = [cell.method for cell in stats.cells(stats.read_results(made))]
    assert names == ["gcivl", "gcivl (sharp)"]
    assert [stats.base(name) for name in names] == ["gcivl", "gcivl"]


def test_runs_without_an_evaluation_are_all_named(tmp_path, config, make_run):
    made = [
        make_run(tmp_path / "done", {1: [[1]]}),
        runs.open_run(tmp_path / "new", config, {}, Statistics.standard(1)),
        runs.open_run(tmp_path / "other", config, {}, Statistics.standard(1)),
    ]
    with pytest.raises(UserError, match=r"no evaluation yet in \S*/new, \S*/other; use"):
        stats.read_results(made)
