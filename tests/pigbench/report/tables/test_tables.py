import dataclasses
import itertools

import pytest

from pigbench import envs
from pigbench.errors import UserError
from pigbench.evaluation import episodes
from pigbench.evaluation.episodes import Episode
from pigbench.report import stats, tables
from pigbench.report.scoring import Scoring

DOUBLE = {"environment": "cube-double"}
ORDER = ("cube-single", "cube-double", "qrl", "gcivl")


@pytest.fixture
def results(tmp_path, make_run):
    return stats.read_results(
        [
            make_run(tmp_path / "a", {1: [[1, 1], [0, 1]]}),
            make_run(tmp_path / "b", {1: [[0, 0], [0, 1]]}, seed=1),
            make_run(tmp_path / "c", {1: [[1, 0], [1, 1]]}, **DOUBLE),
            make_run(tmp_path / "d", {1: [[1, 1], [1, 1]]}, method="qrl", **DOUBLE),
        ]
    )


def seeds(make_run, folder, method, rates, **changes):
    """Runs of one seed each, with a success rate in tenths."""
    return [
        make_run(
            folder / f"{method}-{seed}",
            {1: [[1] * rate + [0] * (10 - rate)]},
            method=method,
            seed=seed,
            **changes,
        )
        for seed, rate in enumerate(rates)
    ]


def test_methods_by_environments(results):
    table = tables.method_table(results, order=ORDER)
    assert tables.render(table, "markdown") == (
        "| method | cube-single | cube-double |\n"
        "| ------ | ----------: | ----------: |\n"
        "| qrl    |           – |   **100.0** |\n"
        "| gcivl  | 50.0 ± 35.4 |        75.0 |\n"
        "\n"
        "Success rate in percent (last evaluation; physics: exact), mean ± standard deviation over "
        "seeds. Bold: the highest of a column and what lies in its 95 % bootstrap interval\n"
    )


def test_tasks_by_methods(results):
    table = tables.task_table(results, order=ORDER)
    assert table.rows == [
        f"{environment} {task}"
        for environment in ("cube-single", "cube-double")
        for task in ("task1", "task2")
    ]
    assert table.columns == ["qrl", "gcivl"]
    values = {label: estimate.value for label, estimate in table.estimates.items()}
    assert values == {
        ("cube-single task1", "gcivl"): 50,
        ("cube-single task2", "gcivl"): 50,
        ("cube-double task1", "gcivl"): 50,
        ("cube-double task2", "gcivl"): 100,
        ("cube-double task1", "qrl"): 100,
        ("cube-double task2", "qrl"): 100,
    }
    # Both reach 100 % of the second task; on one environment there is one method only.
    assert table.bold == {
        ("cube-double task1", "qrl"),
        ("cube-double task2", "qrl"),
        ("cube-double task2", "gcivl"),
    }


def test_bold_is_what_lies_in_the_interval_of_the_highest(tmp_path, make_run):
    # The highest has seeds at 50, 60 and 90 %: three equal draws of the lowest have 1/27, more than
    # 2.5 %, so its interval begins at 50.
    made = [
        *seeds(make_run, tmp_path, "gcivl", (5, 6, 9)),
        *seeds(make_run, tmp_path, "qrl", (5, 5, 5)),
        *seeds(make_run, tmp_path, "crl", (5, 5, 4)),
    ]
    table = tables.method_table(stats.read_results(made))
    assert table.bold == {("gcivl", "cube-single"), ("qrl", "cube-single")}


def test_one_seed_has_exact_ties_only(tmp_path, make_run):
    made = [
        run
        for method, rate in {"gcivl": 6, "qrl": 6, "crl": 5}.items()
        for run in seeds(make_run, tmp_path, method, (rate,))
    ]
    table = tables.method_table(stats.read_results(made))
    assert table.bold == {("gcivl", "cube-single"), ("qrl", "cube-single")}
    assert table.caption.endswith("Bold: the highest of a column; a single seed gives no interval")


def test_aggregates(tmp_path, make_run):
    made = [
        *seeds(make_run, tmp_path, "gcivl", (1, 2, 3, 10)),
        *seeds(make_run, tmp_path, "qrl", (7, 8, 8, 9)),
    ]
    table = tables.aggregate_table(stats.read_results(made), order=ORDER)
    assert (table.rows, table.columns) == (["qrl", "gcivl"], ["IQM", "mean"])
    # Without the lowest and the highest quarter: the mean of 2 and 3, and of 8 and 8, tenths.
    assert table.estimates["gcivl", "IQM"].value == 25
    assert table.estimates["qrl", "IQM"].value == 80
    assert table.estimates["gcivl", "mean"].value == 40
    assert table.bold == {("qrl", "IQM"), ("qrl", "mean")}
    assert table.caption == (
        "Success rate in percent (last evaluation; physics: exact), interquartile mean and mean "
        "over cube-single, with 95 % stratified bootstrap intervals over seeds. Bold: the highest "
        "of a column and what lies in its 95 % bootstrap interval"
    )


def test_aggregates_do_not_depend_on_which_environment_has_more_seeds(tmp_path, make_run):
    made = []
    for method, counts in {"gcivl": (3, 1), "qrl": (1, 3)}.items():
        for environment, rate, count in zip(("one", "two"), (8, 0), counts, strict=True):
            folder, rates = tmp_path / environment, (rate,) * count
            made += seeds(make_run, folder, method, rates, environment=environment)
    table = tables.aggregate_table(stats.read_results(made))
    assert {label: round(one.value, 9) for label, one in table.estimates.items()} == dict.fromkeys(
        itertools.product(("gcivl", "qrl"), ("IQM", "mean")), 40
    )


def test_captions_are_of_the_environments_that_are_compared(tmp_path, make_run):
    goals = {"agent": {"goals": "cubes"}}
    made = [
        *seeds(make_run, tmp_path, "gcivl", (1,)),
        *seeds(make_run, tmp_path, "qrl", (2,)),
        *seeds(make_run, tmp_path / "double", "qrl", (3,), **DOUBLE, **goals),
    ]
    results = stats.read_results(made)
    assert "(last evaluation; physics: exact)" in tables.aggregate_table(results).caption
    said = "goals: cubes (cube-double), state (cube-single)"
    assert said in tables.method_table(results).caption


def test_improvements(tmp_path, make_run):
    made = [
        *seeds(make_run, tmp_path, "gcivl", (1, 2, 3)),
        *seeds(make_run, tmp_path, "qrl", (3, 8, 9)),
    ]
    scoring = Scoring(over="tasks")
    table = tables.improvement_table(stats.read_results(made), order=ORDER, scoring=scoring)
    # Of nine pairs qrl wins eight and ties one.
    assert table.estimates["qrl", "gcivl"].value == pytest.approx(100 * 8.5 / 9)
    assert table.bold == {("qrl", "gcivl")}
    assert "over the tasks of cube-single, with" in table.caption


def test_the_caption_names_the_checkpoint(results):
    caption = tables.method_table(results, scoring=Scoring("best")).caption
    assert "(best checkpoint of the mean over seeds; physics: exact)" in caption


REACHED = {"nearest": 0.012, "touched": True, "held": False, "final_distance": 0.2, "length": 50}


def test_milestones_with_a_dash_for_what_no_file_tells(tmp_path, make_run):
    both = {1: [[0, 1]]}
    farther = REACHED | {"nearest": 0.032}
    table = tables.milestone_table(
        stats.read_results(
            [
                make_run(tmp_path / "a", both, more=REACHED),
                make_run(tmp_path / "b", both, more=farther, seed=1),
                make_run(tmp_path / "c", both, method="qrl", more=REACHED),
                make_run(tmp_path / "d", both, method="qrl", seed=1),
                make_run(tmp_path / "e", {1: [[1, 1]]}, more=REACHED, **DOUBLE),
            ]
        ),
        order=ORDER,
    )
    assert table.rows == ["cube-single qrl", "cube-single gcivl", "cube-double gcivl"]
    lines = tables.render(table, "markdown").splitlines()
    cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in (lines[0], *lines[2:5])]
    shown = list(zip(*cells, strict=True))
    assert shown[1] == ("nearest (cm)", "–", "2.2 ± 1.4", "1.2")
    assert shown[2] == ("touched", "–", "100.0 ± 0.0", "100.0")
    assert shown[3] == ("held", "–", "0.0 ± 0.0", "0.0")
    assert shown[4] == ("lifted", "–", "–", "–")
    assert shown[7] == ("success", "50.0 ± 0.0", "50.0 ± 0.0", "100.0")
    assert shown[9] == ("final (cm)", "–", "20.0 ± 0.0", "20.0")
    assert shown[10] == ("steps", "–", "50.0 ± 0.0", "50.0")


@pytest.mark.parametrize("draw", [tables.milestone_table, tables.threshold_table])
@pytest.mark.parametrize(
    ("environments", "said"),
    [
        (["cube-single", "cube-double"], "success (within 4 cm) ends an episode"),
        (["mine", "nobody's"], "success (within 2.5 cm) ends an episode"),
        (["nobody's"], "success ends an episode"),
        (
            ["mine", "cube-single", "cube-double"],
            "success (within 2.5 cm in mine, 4 cm in cube-double and cube-single) ends an episode",
        ),
    ],
)
def test_success_is_as_near_as_it_is_in_the_tables_environments(
    tmp_path, make_run, monkeypatch, draw, environments, said
):
    own = dataclasses.replace(envs.get("cube-single"), name="mine", success_distance=0.025)
    monkeypatch.setitem(envs.SPECS, own.name, own)
    runs = [make_run(tmp_path / name, {1: [[1]]}, environment=name) for name in environments]
    assert said in draw(stats.read_results(runs)).caption


def test_the_final_distance_is_that_of_episodes_with_an_end(tmp_path, make_run):
    run = make_run(tmp_path / "a", {1: [[0, 0]]})
    lost = {"success": False, "diverged": True}
    ended = lost | {"diverged": False, "final_distance": 0.1}
    episodes.record(
        run.episodes_path,
        [
            Episode(1, 1, "lift", number, 7, "mujoco", one)
            for number, one in enumerate((lost, ended, ended))
        ],
    )
    estimates = tables.milestone_table(stats.read_results([run])).estimates
    assert estimates["cube-single gcivl", "final (cm)"].value == pytest.approx(10)
    assert estimates["cube-single gcivl", "diverged"].value == pytest.approx(100 / 3)


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({}, "(last evaluation; physics: exact)"),
        ({"gcivl": "cubes", "qrl": "cubes"}, "(last evaluation; physics: exact; goals: cubes)"),
        ({"gcivl": "cubes"}, "exact; goals: cubes (gcivl), state (qrl))"),
    ],
)
def test_the_caption_says_what_methods_were_told_of_goals(tmp_path, make_run, told, said):
    runs = [
        make_run(
            tmp_path / method,
            {1: [[1]]},
            method=method,
            agent={"goals": told[method]} if method in told else {},
        )
        for method in ("gcivl", "qrl")
    ]
    assert said in tables.method_table(stats.read_results(runs)).caption


def test_goals_of_two_kinds_do_not_share_a_cell(tmp_path, make_run):
    runs = [
        make_run(tmp_path / goals, {1: [[1]]}, seed=seed, agent={"goals": goals})
        for seed, goals in enumerate(("state", "cubes"))
    ]
    with pytest.raises(UserError, match="goals"):
        tables.method_table(stats.read_results(runs))
