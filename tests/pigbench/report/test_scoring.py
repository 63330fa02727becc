import numpy as np
import pytest

from pigbench.errors import UserError
from pigbench.report import scoring, stats
from pigbench.report.scoring import Scoring


@pytest.fixture
def results(tmp_path, make_run):
    # Success rates in percent by hand, by seed and at steps 0, 100, 200, 300, two tasks of two
    # episodes: 0, 100, 25, 75 and 0, 50, 75, 25. Means over seeds: 0, 75, 50, 50.
    nothing = [[0, 0], [0, 0]]
    return stats.read_results(
        [
            make_run(
                tmp_path / "0",
                {0: nothing, 100: [[1, 1], [1, 1]], 200: [[0, 1], [0, 0]], 300: [[1, 1], [0, 1]]},
            ),
            make_run(
                tmp_path / "1",
                {0: nothing, 100: [[1, 1], [0, 0]], 200: [[0, 1], [1, 1]], 300: [[0, 0], [0, 1]]},
                seed=1,
            ),
        ]
    )


@pytest.mark.parametrize(
    ("checkpoint", "rates"),
    [("last", (75, 25)), ("last-three", (200 / 3, 50)), ("best", (100, 50))],
)
def test_checkpoints_by_hand(results, checkpoint, rates):
    estimate = scoring.success(results, Scoring(checkpoint))
    assert estimate.value == pytest.approx(np.mean(rates))
    assert estimate.deviation == pytest.approx(np.std(rates, ddof=1))
    assert estimate.interval == pytest.approx(sorted(rates))
    assert estimate.seeds == 2


@pytest.mark.parametrize(
    ("checkpoint", "first", "second"),
    [
        ("last", (100, 0), (50, 50)),
        ("last-three", (250 / 3, 50), (50, 50)),
        # The step is that of all tasks together: the second task alone is best at 200.
        ("best", (100, 100), (100, 0)),
    ],
)
def test_tasks_by_hand(results, checkpoint, first, second):
    tasks = scoring.task_success(results, Scoring(checkpoint))
    assert list(tasks) == [(1, "task1"), (2, "task2")]
    assert [estimate.value for estimate in tasks.values()] == pytest.approx(
        [np.mean(first), np.mean(second)]
    )
    strata = scoring.stratum(results, Scoring(checkpoint, over="tasks"))
    np.testing.assert_allclose(strata, np.transpose([first, second]))


def test_a_run_gives_one_number_an_environment(results):
    np.testing.assert_allclose(scoring.stratum(results, Scoring()), [[75], [25]])


def test_last_three_leaves_out_the_untrained_policy(results):
    short = [
        result._replace(episodes=[e for e in result.episodes if e.step < 300]) for result in results
    ]
    with pytest.raises(UserError, match=r"/0 has too few evaluations for checkpoint 'last-three'"):
        scoring.success(short, Scoring("last-three"))


def test_an_unfinished_run_is_not_averaged_with_a_finished_one(results):
    first, second = results
    half = second._replace(episodes=[e for e in second.episodes if e.step < 300])
    with pytest.raises(UserError, match="last evaluated step is 300 in one and 200 in the other"):
        scoring.success([first, half], Scoring())


def test_one_seed_has_no_interval(results):
    estimate = scoring.success(results[:1], Scoring())
    assert estimate == (75, None, None, 1)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"checkpoint": "bst"}, "unknown checkpoint 'bst': did you mean 'best'"),
        ({"over": "task"}, "unknown unit 'task': did you mean 'tasks'"),
    ],
)
def test_unknown_names_offer_the_nearest(fields, message):
    with pytest.raises(UserError, match=message):
        Scoring(**fields)


def test_what_methods_do_not_share_is_told(tmp_path, make_run):
    once, twice = [[1], [0]], [[1, 0], [0, 0]]
    made = stats.read_results(
        [
            make_run(tmp_path / "a", {100: twice, 200: once}),
            make_run(tmp_path / "b", {100: twice, 200: once}, seed=1),
            make_run(tmp_path / "c", {100: twice}, method="qrl"),
            make_run(tmp_path / "d", {100: twice}, method="crl"),
            # Another environment may have steps of its own.
            make_run(tmp_path / "e", {300: twice}, environment="cube-double"),
        ]
    )
    assert scoring.differences(stats.cells(made), Scoring()) == [
        "unequal last step on cube-single: 100 (crl, qrl); 200 (gcivl)",
        "unequal episodes per task on cube-single: 2 (crl, qrl); 1 (gcivl)",
    ]
    assert scoring.differences(stats.cells(made[2:]), Scoring()) == []


def test_what_follows_the_first_episodes_does_not_count(tmp_path, make_run):
    # Step 100 is better in the first two and step 200 in all.
    curve = {100: [[1, 1, 0, 0, 0, 0]], 200: [[1, 0, 1, 1, 1, 1]]}
    few = {100: [[1, 1]], 200: [[1, 0]]}
    many = stats.read_results([make_run(tmp_path / "many", curve)])
    cut = stats.read_results([make_run(tmp_path / "few", few)])
    for checkpoint in ("last", "best"):
        first = Scoring(checkpoint, first_episodes=2)
        (group,) = first.cells(many).values()
        assert scoring.success(group, first) == scoring.success(cut, Scoring(checkpoint))
    assert scoring.success(cut, Scoring("best")).value == 100
    assert scoring.success(many, Scoring("best")).value == pytest.approx(500 / 6)


def test_evaluations_are_held_against_each_other_by_what_counts(tmp_path, make_run):
    made = stats.read_results(
        [
            make_run(tmp_path / "a", {100: [[1] * 5]}),
            make_run(tmp_path / "b", {100: [[0] * 2]}, seed=1),
            make_run(tmp_path / "c", {100: [[1] * 3]}, method="qrl"),
        ]
    )
    with pytest.raises(UserError, match="episodes per task at step 100"):
        Scoring().cells(made)
    with pytest.raises(UserError, match="episodes per task at step 100"):
        Scoring(first_episodes=3).cells(made)
    equal = Scoring(first_episodes=2)
    cells = equal.cells(made)
    assert scoring.differences(cells, equal) == []
    assert scoring.wording(cells, equal) == "last evaluation, 2 episodes per task"


@pytest.mark.parametrize(
    ("count", "said"),
    [
        (None, ""),
        (2, ", 2 episodes per task"),
        (4, ", 3 and 4 episodes per task"),
        (100, ", 3 and 5 episodes per task"),
    ],
)
def test_captions_tell_of_episodes_that_there_are(tmp_path, make_run, count, said):
    made = stats.read_results(
        [
            make_run(tmp_path / "a", {100: [[1] * 5]}),
            make_run(tmp_path / "c", {100: [[1] * 3]}, method="qrl"),
        ]
    )
    first = Scoring(first_episodes=count)
    assert scoring.wording(first.cells(made), first) == f"last evaluation{said}"
