"""The command line end to end on a tiny case, and what it says to bad input."""

import csv
import io
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pigbench import cli, envs
from pigbench.errors import UserError
from pigbench.evaluation import episodes
from pigbench.evaluation.measures import MEASURES

SMALL = ["--episode-length", "31", "--episodes-per-shard", "2"]
GENERATE = ["generate", "cube-single", "--episodes", "3", "--validation-episodes", "1", *SMALL]
TINY_NETWORKS = [
    *("--agent.batch-size", "8"),
    *("--agent.value-hidden-sizes", "8"),
    *("--agent.actor-hidden-sizes", "8"),
]
SCHEDULE = ["--steps", "4", "--log-every", "1", "--evaluate-every", "2"]
TRAIN = ["--preset", "cpu", *TINY_NETWORKS, *SCHEDULE, "--evaluation.episodes", "1"]


def train(method: str, data: Path, out: Path, *more: str) -> None:
    cli.run(["train", method, "--data", str(data), "--out", str(out), *TRAIN, *more])


@pytest.fixture(scope="session")
def data(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("cli") / "data"
    cli.run([*GENERATE, "--out", str(folder)])
    return folder


@pytest.fixture(scope="session")
def run(data, short_episodes, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("cli") / "run"
    with short_episodes():
        train("hjb-gcivl", data, folder)
    return folder


def test_lists_name_environments_and_methods(capsys):
    cli.run(["list", "envs"])
    cli.run(["list", "methods"])
    printed = capsys.readouterr().out
    assert "1 cube, 5 tasks" in printed
    assert "2 cubes, 5 tasks" in printed
    names = {line.split()[0] for line in printed.splitlines()}
    assert {"cube-single", "cube-octuple", "gcivl", "eik-gcivl", "hjb-gcivl"} <= names


def test_a_generated_data_set_is_whole(data, capsys):
    cli.run(["data", "verify", str(data)])
    cli.run(["data", "info", str(data)])
    out = capsys.readouterr().out
    assert "is intact" in out
    assert "93 rows, 3 of 3 episodes" in out


def test_a_run_has_metrics_checkpoint_and_episodes(run):
    assert (run / "metrics.jsonl").read_text().count("\n") == 4
    assert (run / "checkpoints" / "4").is_dir()
    rows = episodes.read(run / "episodes.csv")
    assert {row.step for row in rows} == {0, 2, 4}
    assert len(rows) == 3 * 5
    assert all(row.measures.keys() == MEASURES.keys() for row in rows)


def test_finished_work_is_not_done_again(data, run, capsys):
    before = {path: path.stat().st_mtime_ns for path in run.rglob("*.csv")}
    shards = {path: path.stat().st_mtime_ns for path in data.rglob("*.npy")}
    cli.run([*GENERATE, "--out", str(data)])
    train("hjb-gcivl", data, run)
    assert before == {path: path.stat().st_mtime_ns for path in run.rglob("*.csv")}
    assert shards == {path: path.stat().st_mtime_ns for path in data.rglob("*.npy")}


def test_an_evaluation_replaces_that_of_the_same_step(run, short, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(envs, "default_engine", lambda: "mjx-warp")  # as on another machine

    def last_rows(folder: Path) -> dict[tuple[int, int], episodes.Episode]:
        rows = episodes.read(folder / "episodes.csv")
        return {(row.task, row.episode): row for row in rows if row.step == 4}

    copy = tmp_path / "run"
    shutil.copytree(run, copy)
    cli.run(["evaluate", str(copy), "--episodes", "2"])
    rows = last_rows(copy)
    assert list(rows) == [(task, episode) for task in range(1, 6) for episode in (0, 1)]
    assert last_rows(run).items() <= rows.items()
    assert {row.engine for row in rows.values()} == {"mujoco"}
    assert (
        "replacing the 5 episodes of step 4 (seed 0, mujoco) by 10 (seed 0, mujoco)"
        in capsys.readouterr().out
    )

    before = (copy / "episodes.csv").read_bytes()
    with pytest.raises(
        UserError, match=r"replace the 10 episodes .* by 5 \(seed 3, mujoco\): .*--replace"
    ):
        cli.run(["evaluate", str(copy), "--episodes", "1", "--seed", "3"])
    assert (copy / "episodes.csv").read_bytes() == before
    cli.run(["evaluate", str(copy), "--episodes", "1", "--seed", "3", "--replace"])
    assert {row.seed for row in last_rows(copy).values()} == {3}


def test_a_policy_can_be_tried_in_noise(run, short, tmp_path, capsys):
    copy = tmp_path / "run"
    shutil.copytree(run, copy)
    before = (copy / "episodes.csv").read_bytes()
    cli.run(["evaluate", str(copy), "--episodes", "1", "--noise", "20"])
    assert (copy / "episodes.csv").read_bytes() == before
    noisy = episodes.read(copy / "noise" / "20.csv")
    assert [row.task for row in noisy] == [1, 2, 3, 4, 5]
    assert noisy != [row for row in episodes.read(copy / "episodes.csv") if row.step == 4]
    cli.run(["table", str(copy), "--show", "noise"])
    assert "20 mm" in capsys.readouterr().out
    for level in ("-1", "1e30"):
        with pytest.raises(UserError, match=r"noise is .*: it must be from 0 to 1000 mm"):
            cli.run(["evaluate", str(copy), "--noise", level])


def test_a_policy_can_be_held_against_ogbench(run, short, tmp_path, capsys):
    file = tmp_path / "pairs.json"
    cli.run(["parity", "policy", str(run), "--episodes", "1", "--json", str(file)])
    assert "| all tasks " in capsys.readouterr().out
    kept = json.loads(file.read_text())
    assert kept["settings"]["run_folder"] == str(run)
    header, *tasks, together = kept["pairs"]
    assert [sum(map(int, line[1:5])) for line in (*tasks, together)] == [1] * 5 + [5]
    assert together[header.index("neither")] == "5"
    assert together[5:] == ["0.0 %", "0.0 %", "1"]


def test_table_and_plot_need_the_saved_files_only(run, tmp_path, capsys):
    copy = tmp_path / "run"
    copy.mkdir()
    for name in ("config.json", "episodes.csv"):
        shutil.copy(run / name, copy)
    cli.run(["table", str(copy), "--format", "csv"])
    table = list(csv.reader(io.StringIO(capsys.readouterr().out)))
    assert ["hjb-gcivl", "cube-single"] in [row[:2] for row in table]
    cli.run(["plot", str(copy), "--out", str(tmp_path / "curves.png")])
    picture = np.asarray(Image.open(tmp_path / "curves.png"))
    assert picture.std() > 1


WRONG = {
    "unknown command": (["trian", "gcivl"], "unknown command 'trian': did you mean 'train'?"),
    "unknown command of two words": (["data", "inof"], "'data inof': did you mean 'data info'?"),
    "unknown environment": (
        ["generate", "cube-singel", "--out", "D"],
        "mean 'cube-single'?",
    ),
    "unknown policy": (["generate", "cube-single", "--out", "D", "--policy", "ply"], "'play'"),
    "unknown profile": (["generate", "cube-single", "--out", "D", "--physics", "exat"], "'exact'"),
    "unknown engine": (["generate", "cube-single", "--out", "D", "--engine", "mujco"], "'mujoco'"),
    "unknown method": (["train", "gcivil", "--data", "D", "--out", "R"], "did you mean 'gcivl'?"),
    "unknown preset": (
        ["train", "gcivl", "--data", "D", "--out", "R", "--preset", "papr"],
        "did you mean 'paper'?",
    ),
    "unknown field": (
        ["train", "gcivl", "--data", "D", "--out", "R", "--agent.discont", "1"],
        "--agent.discount",
    ),
    "unreadable value": (["generate", "cube-single", "--out", "D", "--seed", "x"], "--seed"),
    "impossible value": (
        ["generate", "cube-single", "--out", "D", "--episodes", "0"],
        "at least 1",
    ),
    "negative validation": (
        ["generate", "cube-single", "--out", "D", "--validation-episodes", "-5"],
        "validation_episodes is -5",
    ),
    "more than the disk": (
        ["generate", "cube-single", "--out", "D", "--episodes", "100000000000"],
        "D needs",
    ),
    "more than the memory": (
        ["generate", "cube-single", "--out", "D", "--episodes-per-shard", "100000000000"],
        "100,000,000,000 simulations at once take",
    ),
    "noise without levels": (["evaluate", "R", "--noise"], "--noise needs at least one value"),
    "seeds without numbers": (
        ["train", "gcivl", "--data", "D", "--out", "R", "--seeds", "--steps", "5"],
        "--seeds needs at least one value",
    ),
    "layers without sizes": (
        ["train", "gcivl", "--data", "D", "--out", "R", "--agent.actor-hidden-sizes"],
        "--agent.actor-hidden-sizes needs at least one value",
    ),
    "seed beside seeds": (
        ["train", "gcivl", "--data", "D", "--out", "R", "--seed", "3", "--seeds", "0", "1"],
        "seed has no effect beside seeds: leave it out",
    ),
    "one seed together": (
        ["train", "gcivl", "--data", "D", "--out", "R", "--seeds", "0", "--vectorized"],
        "vectorized has no effect without several seeds: leave it out",
    ),
    "two kinds of goals": (
        ["train", "gcivl", "--data", "D", "--out", "R", "--goals", "state", "--agent.goals=cubes"],
        "goals is 'state', but agent.goals is 'cubes': leave one out",
    ),
    "two kinds of goals, the other way round": (
        ["train", "gcivl", "--data", "D", "--out", "R", "--goals=cubes", "--agent.goals", "state"],
        "goals is 'cubes', but agent.goals is 'state': leave one out",
    ),
    "length of episodes that end themselves": (
        ["generate", "cube-centre", "--out", "D", "--episode-length", "7"],
        "episode_length has no effect with policy 'replan', which ends its episodes itself: leave",
    ),
    "more cubes than a policy can move": (
        ["generate", "cube-double", "--out", "D", "--policy", "replan"],
        "cube-double has 2 cubes, and replan moves no more than 1: choose another policy",
    ),
    "shares of no cluster": (
        ["generate", "cube-single", "--out", "D", "--cpus-per-task", "2"],
        "cpus_per_task has no effect without ray: leave it out",
    ),
    "shares of no cluster, in a suite": (
        ["suite", "cpu-flat", "--out", "S", "--gpus-per-task", "1"],
        "gpus_per_task has no effect without ray: leave it out",
    ),
    "missing option": (["train", "gcivl", "--data", "D"], "--out"),
    "missing data set": (["data", "info", "D"], "pigbench generate"),
    "missing run": (["evaluate", "R"], "pigbench train"),
    "no runs": (["table"], "no runs"),
}


@pytest.mark.parametrize("arguments, says", WRONG.values(), ids=WRONG)
def test_bad_input_gets_one_clear_line_and_status_2(arguments, says, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["pigbench", *arguments])
    with pytest.raises(SystemExit) as stop:
        cli.main()
    error = capsys.readouterr().err
    assert stop.value.code == 2
    assert says in error
    assert error.startswith("pigbench: ")
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", cli.COMMANDS)
def test_an_interrupted_command_says_what_running_it_again_does(name, monkeypatch, capsys):
    def interrupt(arguments):
        os.kill(os.getpid(), signal.SIGTERM)

    def leave(status):
        raise SystemExit(status)

    monkeypatch.setattr(cli, "run", interrupt)
    monkeypatch.setattr(os, "_exit", leave)
    monkeypatch.setattr(sys, "argv", ["pigbench", *name.split(), "--out", "x"])
    with pytest.raises(SystemExit) as stop:
        cli.main()
    assert stop.value.code == 143
    resume = ("generate", "data filter", "data push", "data pull", "data import", "train", "suite")
    then = "go on" if name in resume else "begin anew"
    expected = f"pigbench: interrupted; run the same command again to {then}\n"
    assert capsys.readouterr().err == expected


def test_a_torn_data_set_is_named(data, tmp_path):
    copy = tmp_path / "data"
    shutil.copytree(data, copy)
    torn = copy / "train-00000" / "actions.npy"
    torn.write_bytes(torn.read_bytes()[:-8])
    with pytest.raises(UserError, match=r"train-00000/actions\.npy is torn"):
        train("gcivl", copy, tmp_path / "run")


def test_nan_in_a_data_set_is_named(data, tmp_path):
    copy = tmp_path / "data"
    shutil.copytree(data, copy)
    path = copy / "train-00001" / "observations.npy"
    observations = np.load(path, mmap_mode="r+")
    observations[7, 3] = np.nan
    observations.flush()
    with pytest.raises(UserError, match=r"train-00001/observations\.npy holds NaN"):
        train("gcivl", copy, tmp_path / "run")
    with pytest.raises(UserError, match="faults"):
        cli.run(["data", "verify", str(copy)])


def test_a_run_of_another_configuration_is_left_alone(data, run, tmp_path):
    with pytest.raises(UserError, match=r"discount"):
        train("hjb-gcivl", data, run, "--agent.discount", "0.5")


def test_a_torn_checkpoint_is_named(run, tmp_path):
    copy = tmp_path / "run"
    shutil.copytree(run, copy)
    for path in (copy / "checkpoints" / "4").rglob("d/*"):
        path.write_bytes(b"")
    with pytest.raises(UserError, match=r"checkpoints/4 cannot be read"):
        cli.run(["evaluate", str(copy)])


def test_hints_can_be_pasted(data, tmp_path, capsys):
    out = tmp_path / "it's a folder"
    shutil.copytree(data, out)
    cli.run([*GENERATE, "--out", str(out)])
    command = capsys.readouterr().out.split("see it with: pigbench ")[1]
    cli.run(shlex.split(command))
    assert "93 rows" in capsys.readouterr().out


def test_output_in_ascii(tmp_path, make_run):
    runs = [make_run(tmp_path / str(seed), {1: [[1]]}, seed=seed).path for seed in (0, 1)]
    done = subprocess.run(
        [sys.executable, "-P", "-m", "pigbench", "table", *runs],
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
        capture_output=True,
    )
    assert done.returncode == 0, done.stderr
    assert b"100.0 +/- 0.0" in done.stdout


def test_a_name_that_is_no_text_is_said(tmp_path):
    done = subprocess.run(
        [sys.executable, "-P", "-m", "pigbench", "data", "info", os.fsencode(tmp_path) + b"/\xff"],
        capture_output=True,
    )
    assert done.returncode == 2
    assert done.stderr.startswith(b"pigbench: ")
    assert done.stderr.count(b"\n") == 1


def test_what_the_system_refuses_is_one_line(monkeypatch, capsys):
    def refuse(arguments):
        raise PermissionError(13, "Permission denied", "somewhere/manifest.json")

    monkeypatch.setattr(cli, "run", refuse)
    with pytest.raises(SystemExit) as stop:
        cli.main()
    assert stop.value.code == 2
    expected = "pigbench: somewhere/manifest.json: Permission denied\n"
    assert capsys.readouterr().err == expected
