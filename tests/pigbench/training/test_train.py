"""Training that is killed and started again ends where an uninterrupted one does."""

import dataclasses
import itertools
import json
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import optax
import pytest

from pigbench import agents, cli
from pigbench.data.sampler import Rows
from pigbench.errors import UserError
from pigbench.evaluation import episodes
from pigbench.layout import Layout, Space
from pigbench.runs.restore import Trained, restore
from pigbench.runs.run import read_run
from pigbench.training.batches import Drawn
from pigbench.training.schedule import Schedule
from pigbench.training.updates import make_updates

STEPS = 200
SMALL = [
    *("--preset", "cpu", "--steps", "20", "--evaluate-every", "10", "--log-every", "5"),
    *("--agent.value-hidden-sizes", "32", "--agent.actor-hidden-sizes", "32"),
    *("--agent.batch-size", "32", "--evaluation.episodes", "1"),
]


@pytest.fixture
def data(played) -> Path:
    return played


def parameters(folder: Path) -> list[np.ndarray]:
    state = restore(folder).state
    assert int(state.step) == STEPS
    return [np.asarray(leaf) for leaf in jax.tree.leaves(state)]


def test_a_killed_run_ends_with_the_same_parameters_to_the_bit(data, tmp_path):
    options = [
        *("train", "hjb-gcivl", "--data", str(data), "--preset", "cpu", "--steps", str(STEPS)),
        *("--evaluate-every", "100", "--log-every", "10", "--evaluation.episodes", "1"),
        *("--agent.value-hidden-sizes", "64", "--agent.actor-hidden-sizes", "64", "64"),
        *("--agent.batch-size", "32"),
    ]
    cli.run([*options, "--out", str(tmp_path / "whole")])

    cut = tmp_path / "cut"
    command = [sys.executable, "-c", "from pigbench.cli import main; main()"]
    process = subprocess.Popen([*command, *options, "--out", str(cut)], stderr=subprocess.DEVNULL)
    while not list(cut.glob("checkpoints/[1-9]*")) and process.poll() is None:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL, "the run ended before it could be killed"
    cli.run([*options, "--out", str(cut)])

    for one, other in zip(parameters(tmp_path / "whole"), parameters(cut), strict=True):
        np.testing.assert_array_equal(one, other)
    for name in ("episodes.csv", "metrics.jsonl"):
        assert (tmp_path / "whole" / name).read_text() == (cut / name).read_text()


def test_updates_do_not_depend_on_how_they_are_cut_into_calls():
    rng = np.random.default_rng(0)
    rows = Rows.create(
        rng.normal(size=(60, 4)).astype(np.float32),
        rng.uniform(-1, 1, size=(60, 2)).astype(np.float32),
        np.arange(60) % 20 == 19,
    )
    small = {"value_hidden_sizes": (16,), "actor_hidden_sizes": (16,), "batch_size": 16}
    config = dataclasses.replace(agents.get("gcivl").preset("cpu"), **small)
    agent = agents.build("gcivl", config, Space(Layout.of({"state": 4}), 2))
    updates = make_updates(agent, jax.random.key(3), Drawn(rows, agent))

    def after(*counts: int) -> list[np.ndarray]:
        state = agents.create(agent, jax.random.key(0))
        for start, stop in itertools.pairwise((0, *itertools.accumulate(counts))):
            state, _ = updates(state, start, stop)
        return [np.asarray(leaf) for leaf in jax.tree.leaves(state)]

    for one, other in zip(after(7), after(3, 4), strict=True):
        np.testing.assert_array_equal(one, other)


def test_seeds_trained_together_are_those_trained_alone(data, short, tmp_path):
    """To rounding: a batched product adds up in another order, and Adam magnifies it."""

    def train(out: Path, *seeds: str) -> None:
        cli.run(["train", "hjb-gcivl", "--data", str(data), "--out", str(out), *seeds, *SMALL])

    def distance(one: Trained, other: Trained) -> float:
        differences = jax.tree.map(jnp.subtract, one.state.params, other.state.params)
        return float(optax.tree.norm(differences))

    train(tmp_path / "together", "--seeds", "5", "7", "--vectorized")
    train(tmp_path / "alone", "--seed", "7")
    five, seven = (restore(tmp_path / "together" / seed) for seed in ("5", "7"))
    alone = restore(tmp_path / "alone")
    assert seven.run.config == alone.run.config
    fresh = agents.create(alone.agent, jax.random.split(jax.random.key(7))[0])
    training = distance(alone, alone._replace(state=fresh))
    assert distance(seven, alone) < 0.02 * training
    assert distance(five, alone) > training


@pytest.mark.parametrize("home", ["device", "disk"])
def test_seeds_cut_off_at_different_steps_go_on_from_the_last_they_share(
    data, short, tmp_path, capsys, home
):
    train = ["train", "gcivl", "--data", str(data), "--out", str(tmp_path / "run"), *SMALL]
    seeds = ["--seeds", "0", "1", "--vectorized", "--rows", home]
    cli.run([*train, *seeds])
    assert f"rows on {home} (as asked)" in capsys.readouterr().err
    whole = {seed: (tmp_path / f"run/{seed}/metrics.jsonl").read_text() for seed in (0, 1)}
    shutil.rmtree(tmp_path / "run/1/checkpoints/20")
    cli.run([*train, *seeds])
    for seed, metrics in whole.items():
        assert (tmp_path / f"run/{seed}/metrics.jsonl").read_text() == metrics
        assert int(restore(tmp_path / f"run/{seed}").state.step) == 20


def test_seeds_that_are_trained_already_are_not_begun_anew_with_others(data, short, tmp_path):
    train = ["train", "gcivl", "--data", str(data), "--out", str(tmp_path / "run"), *SMALL]
    cli.run([*train, "--seeds", "0"])

    def contents() -> dict[Path, bytes]:
        files = (path for path in (tmp_path / "run/0").rglob("*") if path.is_file())
        return {path: path.read_bytes() for path in files}

    before = contents()
    with pytest.raises(UserError, match=r"seeds 0 \(step 20\), 1 \(step 0\) .* ask for --seeds 1$"):
        cli.run([*train, "--seeds", "0", "1", "--vectorized"])
    assert contents() == before


@pytest.mark.parametrize("keep", ["last", "all"])
def test_a_run_that_is_extended_is_as_if_it_had_been_that_long_from_the_first(
    data, short, tmp_path, keep
):
    train = ["train", "gcivl", "--data", str(data), *SMALL, "--log-every", "4", "--keep", keep]
    cli.run([*train, "--steps", "40", "--out", str(tmp_path / "whole")])
    # Its last evaluation, after 25 updates, is none of a longer run's.
    cli.run([*train, "--steps", "25", "--out", str(tmp_path / "run")])
    short = read_run(tmp_path / "run")
    episodes.record(short.noise_path(5), episodes.read(short.episodes_path))
    for name in ("000000020", "000000025", "mine"):
        (short.films_path / name).mkdir(parents=True)
        (short.films_path / name / "task1-success.mp4").touch()
    cli.run([*train, "--steps", "40", "--out", str(tmp_path / "run")])
    assert {row.step for row in episodes.read(short.noise_path(5))} == {0, 10, 20}
    assert {path.name for path in short.films_path.iterdir()} == {"000000020", "mine"}

    whole, run = restore(tmp_path / "whole"), restore(tmp_path / "run")
    jax.tree.map(np.testing.assert_array_equal, run.state, whole.state)
    for name in ("episodes.csv", "metrics.jsonl", "config.json", "statistics.json"):
        assert (tmp_path / "run" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
    kept = [{path.name for path in (one.run.checkpoints_path).iterdir()} for one in (run, whole)]
    assert kept[0] == kept[1] == ({"30", "40"} if keep == "last" else {"0", "10", "20", "30", "40"})
    provenance = json.loads((tmp_path / "run/provenance.json").read_text())
    assert provenance["extended"]["40"]["from_steps"] == 25
    assert provenance["extended"]["40"]["versions"] == provenance["versions"]

    with pytest.raises(UserError, match=r"steps is 40 there and 30 now"):
        cli.run([*train, "--steps", "30", "--out", str(tmp_path / "run")])
    with pytest.raises(UserError, match=r"agent\.discount is 0\.99 there and 0\.9 now"):
        cli.run([*train, "--steps", "50", "--agent.discount", "0.9", "--out", str(run.run.path)])


def test_the_best_checkpoint_stays_and_can_be_asked_for(data, short, tmp_path):
    run = tmp_path / "run"
    train = ["train", "gcivl", "--data", str(data), "--out", str(run), *SMALL, "--keep", "best"]
    cli.run([*train, "--steps", "40"])
    # No policy succeeds, so the first is the best.
    assert {path.name for path in (run / "checkpoints").iterdir()} == {"0", "30", "40"}
    rows = episodes.read(run / "episodes.csv")
    won = [r._replace(measures={**r.measures, "success": True}) for r in rows if r.step == 30]
    episodes.record(run / "episodes.csv", won)
    for asked, step in {"last": 40, "best": 30, "0": 0}.items():
        assert int(restore(run, checkpoint=asked).state.step) == step
    with pytest.raises(UserError, match=r"no checkpoint of step 10, only of 0, 30, 40: --keep"):
        restore(run, checkpoint="10")
    for asked in ("first", "9" * 5000):
        with pytest.raises(UserError, match=r"checkpoint is .*: it must be last, best or a"):
            restore(run, checkpoint=asked)


def test_goals_are_kept_and_evaluated_as_trained(data, short, tmp_path):
    run = tmp_path / "run"
    cli.run(["train", "gcivl", "--data", str(data), "--out", str(run), *SMALL, "--goals", "cubes"])
    trained = restore(run)
    assert (trained.run.config.agent["goals"], trained.agent.goal_size) == ("cubes", 3)
    before = (run / "episodes.csv").read_text()
    cli.run(["evaluate", str(run), "--episodes", "1"])
    assert (run / "episodes.csv").read_text() == before


def test_goals_that_a_method_cannot_have_are_refused(data, tmp_path):
    train = ["train", "qrl", "--data", str(data), "--out", str(tmp_path / "run"), *SMALL]
    for option in ("--goals", "--agent.goals"):
        with pytest.raises(UserError, match=r"goals is 'cubes': a quasimetric .*be 'state'"):
            cli.run([*train, option, "cubes"])
    assert not (tmp_path / "run").exists()


def test_a_seed_named_twice_is_refused(data, tmp_path):
    train = ["train", "gcivl", "--data", str(data), "--out", str(tmp_path / "run")]
    with pytest.raises(UserError, match="seeds names one twice: 1, 1"):
        cli.run([*train, "--seeds", "1", "1"])


def test_the_schedule_stops_where_there_is_something_to_do():
    schedule = Schedule(steps=25, log_every=4, evaluate_every=10)
    stops, step = [], 0
    while step < 25:
        step = schedule.next_stop(step)
        stops.append(step)
    assert stops == [4, 8, 10, 12, 16, 20, 24, 25]


def test_an_impossible_schedule_is_refused():
    with pytest.raises(UserError, match="log_every is 0"):
        Schedule(log_every=0)
