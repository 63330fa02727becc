"""Success by final distance, beside the paper's, and by noise."""

import pytest

from pigbench.errors import UserError
from pigbench.evaluation import episodes
from pigbench.evaluation.episodes import Episode
from pigbench.report import paper, stats, tables
from pigbench.report.scoring import Scoring


def ended(*distances: float | None, step: int = 1) -> list[Episode]:
    """Episodes that ended so far from the goal, in metres; None is one that diverged."""
    return [
        Episode(step, 1, "task1", number, 7, "mujoco", {"success": False, **_end(distance)})
        for number, distance in enumerate(distances)
    ]


def _end(distance: float | None) -> dict:
    return {"diverged": True} if distance is None else {"final_distance": distance}


@pytest.fixture
def make_ended(tmp_path, make_run):
    """`make_ended(method, [distances of a seed, ...])`: runs of cube-centre."""

    def make(method: str, *seeds: list, **changes) -> list[stats.Result]:
        settings = {"method": method, "environment": "cube-centre", **changes}
        runs = [
            make_run(tmp_path / f"{method}-{seed}", {}, seed=seed, **settings)
            for seed in range(len(seeds))
        ]
        for run, distances in zip(runs, seeds, strict=True):
            episodes.record(run.episodes_path, ended(*distances))
        return stats.read_results(runs)

    return make


def record_noise(run, level: float, *distances: float, seed: int = 7) -> None:
    run.noise_path(level).parent.mkdir(exist_ok=True)
    made = [episode._replace(seed=seed) for episode in ended(*distances)]
    episodes.record(run.noise_path(level), made)


def values(table, row: str) -> dict[str, float]:
    return {
        column: round(table.estimates[row, column].value, 1)
        for column in table.columns
        if (row, column) in table.estimates
    }


def test_final_distances_are_held_against_three_thresholds(make_ended):
    results = make_ended("gcivl", [0.01, 0.03, 0.0301, None], [0.04, 0.05, 0.1, 0.2])
    table = tables.threshold_table(results)
    ours = {"3 cm": 25.0, "5 cm": 62.5, "10 cm": 75.0}
    theirs = {"paper, 3 cm": 25.0, "paper, 5 cm": 40.0, "paper, 10 cm": 45.0}
    assert values(table, "cube-centre gcivl") == ours | theirs
    assert table.columns == [*ours, *theirs]
    assert table.estimates["cube-centre gcivl", "3 cm"].deviation == pytest.approx(35.36, abs=0.01)
    assert "20 episodes of one seed" in table.caption


def test_other_environments_have_no_number_of_the_papers(make_ended):
    results = make_ended("gcivl", [0.01, 0.06], environment="cube-single")
    table = tables.threshold_table(results)
    assert values(table, "cube-single gcivl") == {"3 cm": 50.0, "5 cm": 50.0, "10 cm": 100.0}
    assert "paper" not in tables.render(table, "csv")


def test_the_papers_protocol_is_the_first_episodes(make_ended):
    results = make_ended("hjb-gcivl", [0.01] * 20 + [0.2] * 30)
    scoring = Scoring(first_episodes=20)
    table = tables.threshold_table(results, scoring=scoring)
    assert values(table, "cube-centre hjb-gcivl")["3 cm"] == 100.0
    assert "20 episodes per task" in table.caption
    assert values(tables.threshold_table(results), "cube-centre hjb-gcivl")["3 cm"] == 40.0
    with pytest.raises(UserError, match="first_episodes is 0"):
        Scoring(first_episodes=0)


def test_the_papers_numbers_never_fall_with_distance():
    for numbers in paper.ROBOT.values():
        assert list(numbers) == [0.03, 0.05, 0.10]
        assert sorted(numbers.values()) == list(numbers.values())


def test_success_by_noise(make_ended):
    results = make_ended("gcivl", [0.01], [0.01]) + make_ended("hjb-gcivl", [0.01])
    first, second, other = (result.run for result in results)
    for run, level, distances in [
        (first, 0, [0.01, 0.04]),
        (second, 0, [0.04, 0.2]),
        (first, 20, [0.2, 0.2]),
        (second, 20, [0.2, 0.09]),
        (first, 2.5, [0.01]),  # not of both seeds
        (other, 20, [0.02, 0.02]),
    ]:
        record_noise(run, level, *distances)
    table = tables.noise_table(results, order=["gcivl", "hjb-gcivl"])
    assert table.columns == ["0 mm", "20 mm"]
    assert values(table, "cube-centre gcivl, 3 cm") == {"0 mm": 25.0, "20 mm": 0.0}
    assert values(table, "cube-centre gcivl, 5 cm") == {"0 mm": 75.0, "20 mm": 0.0}
    assert values(table, "cube-centre gcivl, 10 cm") == {"0 mm": 75.0, "20 mm": 25.0}
    assert values(table, "cube-centre hjb-gcivl, 3 cm") == {"20 mm": 100.0}


@pytest.mark.parametrize(
    ("distances", "seed", "message"),
    [
        ([0.1], 7, r"episodes per task at step 1 is \[2\] in one and \[1\] in the other"),
        ([0.1, 0.1], 8, r"evaluation seed at step 1 is \[7\] in one and \[8\] in the other"),
    ],
)
def test_seeds_are_not_averaged_over_unequal_noise(make_ended, distances, seed, message):
    results = make_ended("gcivl", [0.01], [0.01])
    for level in (0, 20):
        for result in results:
            record_noise(result.run, level, 0.01, 0.04)
    record_noise(results[1].run, 20, *distances, seed=seed)
    with pytest.raises(UserError, match=f"in noise of 20 mm: .*{message}"):
        tables.noise_table(results)


def test_the_caption_tells_how_evaluations_in_noise_differ(make_ended):
    results = make_ended("gcivl", [0.01]) + make_ended("qrl", [0.01])
    for result, level, distances in zip(
        [*results, *results], (5, 5, 10, 10), ([0.1], [0.1], [0.1, 0.2, 0.3], [0.1]), strict=True
    ):
        record_noise(result.run, level, *distances)
    unequal = "episodes per task on cube-centre"
    said = f"{unequal}: 3 (gcivl at 10 mm); 1 (gcivl at 5 mm, qrl at 10 mm, qrl at 5 mm)"
    assert (
        f"(last evaluation; physics: exact; unequal {said})" in tables.noise_table(results).caption
    )
    cut = Scoring(first_episodes=1)
    assert (
        "(last evaluation, 1 episodes per task; physics: exact)"
        in tables.noise_table(results, scoring=cut).caption
    )


def test_a_noise_that_not_all_seeds_have_fills_no_table(make_ended):
    results = make_ended("gcivl", [0.01], [0.01])
    assert "noise" not in tables.fillable(results)
    record_noise(results[0].run, 5, 0.01)
    assert "noise" not in tables.fillable(results)
    record_noise(results[1].run, 5, 0.01)
    assert "noise" in tables.fillable(results)


def test_without_noise_there_is_no_such_table(make_ended):
    with pytest.raises(UserError, match="pigbench evaluate --noise"):
        tables.noise_table(make_ended("gcivl", [0.01]))
