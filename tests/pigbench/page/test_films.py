from pigbench.page import films
from pigbench.report import stats
from pigbench.runs.run import read_run


def test_the_latest_success_and_failure_of_each_task(runs):
    names = {
        0: [
            "000000000/task2-failure",
            "000000200/task1-success",
            "000000200/odd",
            "last/task1-success",
        ],
        1: ["000000100/task1-success", "000000100/task2-failure", "000000200/task1-failure"],
    }
    for seed, paths in names.items():
        for path in paths:
            (runs[seed] / "films" / path).parent.mkdir(parents=True, exist_ok=True)
            (runs[seed] / "films" / f"{path}.mp4").touch()
    results = stats.read_results(map(read_run, runs[:2]))
    told = [(film.task, film.outcome, film.label, film.step) for film in films.choose(results)]
    assert told == [
        ("task1", "success", "gcivl, seed 0", 200),
        ("task1", "failure", "gcivl, seed 1", 200),
        ("task2", "failure", "gcivl, seed 1", 100),
    ]


def test_runs_without_films_have_none(runs):
    assert films.choose(stats.read_results(map(read_run, runs))) == []
