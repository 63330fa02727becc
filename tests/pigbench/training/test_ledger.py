"""What trackers are told as a run trains."""

from typing import ClassVar

import numpy as np

from pigbench import agents
from pigbench.agents import Statistics
from pigbench.data.sampler import Rows
from pigbench.evaluation import episodes
from pigbench.evaluation.settings import Evaluation
from pigbench.page.films import choose
from pigbench.report.stats import Result
from pigbench.runs import metrics
from pigbench.runs import run as runs
from pigbench.trackers import Tracker
from pigbench.training.schedule import Schedule
from pigbench.training.train import train


class Told(Tracker):
    calls: ClassVar[list[tuple]] = []

    def scalars(self, step, values):
        self.calls.append((step, dict(values)))

    def film(self, step, name, path):
        self.calls.append((step, name, path))


def test_metrics_success_rates_and_films_are_shown(drawing, env, tmp_path, config):
    draws = np.random.default_rng(0)
    rows = Rows.create(
        draws.normal(size=(60, 28)).astype(np.float32),
        draws.uniform(-1, 1, size=(60, 5)).astype(np.float32),
        np.arange(60) % 20 == 19,
    )
    small = agents.PolicyConfig(batch_size=8, actor_hidden_sizes=(8,))
    agent = agents.build("gcbc", small, env.space)
    run = runs.open_run(tmp_path / "run", config, {}, Statistics.standard(28))
    schedule = Schedule(steps=4, log_every=1, evaluate_every=4)
    train(
        [run],
        agent,
        rows,
        env,
        schedule=schedule,
        evaluation=Evaluation(2),
        shown_by=[Told],
        films=True,
    )
    films = [call for call in Told.calls if len(call) == 3]
    assert films == [
        (
            step,
            f"evaluation/film/{task}/{outcome}",
            run.path / f"films/{step:09d}/{task}-{outcome}.mp4",
        )
        for step in (0, 4)
        for task, outcome in (("solved", "success"), ("far", "failure"))
    ]
    import av

    lengths = {}
    for _, name, path in films[-2:]:
        with av.open(path) as film:
            lengths[name] = len(list(film.decode(video=0)))
    assert list(lengths.values()) == [1, 4]  # of two and seven states, every second
    found = choose([Result(run, episodes.read(run.episodes_path))])
    assert [(film.task, film.outcome, film.step, film.path) for film in found] == [
        ("far", "failure", 4, films[-1][2]),
        ("solved", "success", 4, films[-2][2]),
    ]
    told = [call for call in Told.calls if len(call) == 2]
    assert [step for step, _ in told] == [0, 1, 2, 3, 4, 4]
    evaluation = told[-1][1]
    assert evaluation["evaluation/success"] == 0.5
    assert evaluation["evaluation/solved/success"] == 1.0
    assert evaluation["evaluation/far/success"] == 0.0
    logged = metrics.read(run.path)
    assert [{"step": step, **values} for step, values in told[1:-1]] == logged
