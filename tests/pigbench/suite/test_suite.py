"""A suite from nothing to its tables, cut off, resumed, with a cell that fails."""

import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from pigbench import cli
from pigbench.errors import UserError
from pigbench.suite import jobs, spec

TINY = """
preset = "cpu"
methods = ["gcbc", "gcivl"]
seeds = [0]
agent = {batch_size = 8, actor_hidden_sizes = [8]}
data = {validation_episodes = 0, episode_transitions = 10}
evaluation = {every = 3, episodes = 1}

[[environments]]
name = "cube-single"
transitions = 10
steps = 6
"""
CELLS = ("gcbc/0", "gcivl/0")


def pigbench(*arguments: object) -> subprocess.Popen[str]:
    command = [sys.executable, "-P", "-m", "pigbench", *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def states(out: Path, capsys) -> dict[str, str]:
    capsys.readouterr()
    cli.run(["suite", "status", str(out)])
    rows = [line.split("|") for line in capsys.readouterr().out.splitlines()[2:]]
    return {row[1].strip().removeprefix("cube-single/"): row[2].strip() for row in rows}


@pytest.mark.parametrize(
    "old, new, complaint",
    [
        ("validation_episodes = 0", "seed = -5", "seed is -5"),
        ("episodes = 1}", "episodes = 100000000}", "simulations at once"),
    ],
)
def test_what_its_commands_would_refuse_is_refused_at_once(tmp_path, old, new, complaint):
    file = tmp_path / "suite.toml"
    assert old in TINY
    file.write_text(TINY.replace(old, new))
    with pytest.raises(UserError, match=complaint):
        cli.run(["suite", str(file), "--out", str(tmp_path / "out")])
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('"cube-single"', '"cube-double"', "environment is 'cube-single' there"),
        ("data = {", 'data = {physics = "fast", ', "physics is 'exact' there and 'fast' now"),
    ],
)
def test_data_of_other_simulations_are_refused_at_once(data, tmp_path, old, new, complaint):
    file, out = tmp_path / "suite.toml", tmp_path / "out"
    file.write_text(f'{TINY.replace(old, new)}data = "{data}"\n')
    with pytest.raises(UserError, match=f"{data} was made with .*{complaint}"):
        cli.run(["suite", str(file), "--out", str(out)])
    assert not out.exists()


def test_runs_on_other_data_than_the_generated_are_refused_before_training(tmp_path, make_run):
    file, out = tmp_path / "suite.toml", tmp_path / "out"
    file.write_text(TINY)
    training = cli.parse(jobs.training(suite := spec.read(file), suite.cells()[0], out).arguments)
    config = training.config(0, environment="cube-single", physics="exact", dataset_digest="ab")
    make_run(out / "cube-single/gcbc/0", {6: [[1]]}, **vars(config))
    with pytest.raises(UserError, match=r"gcbc/0 was made .*dataset_digest is 'ab' there"):
        cli.run(["suite", str(file), "--out", str(out)])
    assert (out / "data/cube-single").exists()
    assert not (out / "cube-single/gcivl").exists()


@pytest.fixture(scope="module")
def file(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("suite") / "tiny.toml"
    path.write_text(TINY)
    return path


@pytest.fixture(scope="module")
def out(file) -> Path:
    """A suite that was killed with its first cell under way, then run to its end.

    Of its cells one fails, because another run lies in its folder.
    """
    out = file.parent / "out"
    foreign = out / "cube-single/gcivl/0"
    foreign.mkdir(parents=True)
    (foreign / "config.json").write_text("{}")
    first = pigbench("suite", file, "--out", out, "--jobs", "1")
    while not (out / "cube-single/gcbc/0/config.json").exists():
        assert first.poll() is None, first.communicate()
        time.sleep(0.05)
    first.send_signal(signal.SIGTERM)
    first.communicate()
    second = pigbench("suite", file, "--out", out, "--jobs", "2")
    output, errors = second.communicate()
    assert second.returncode == 1, errors
    assert "cube-single/gcivl/0 failed with exit status 2" in errors
    assert "config.json is altered: it has no checksum" in errors
    (out / "output").write_text(output)
    return out


def test_all_but_the_failing_cell_are_done(out, capsys):
    assert states(out, capsys) == dict.fromkeys(CELLS, "done") | {"gcivl/0": "failed"}


def test_tables_and_figures_are_those_of_the_cells_that_are_done(out):
    table = (out / "tables.md").read_text()
    assert "| gcbc" in table
    assert "| gcivl" not in table
    assert (out / "tables.tex").read_text().startswith(r"\documentclass")
    assert {path.name for path in out.glob("*.png")} == {
        "curves.png",
        "bars.png",
        "box.png",
        "profile.png",
        "milestones.png",
    }


def test_the_page_names_the_cell_that_failed(out):
    assert f"{out / 'report/index.html'} shows them" in (out / "output").read_text()
    page = (out / "report/index.html").read_text()
    assert "1 of 2 runs is unfinished" in page
    assert 'class="state state-failed"' in page
    assert "pigbench train gcbc --data" in page


def test_a_mended_cell_is_done_and_the_others_are_left_alone(out, file, tmp_path, capsys):
    copy = tmp_path / "copy"
    shutil.copytree(out, copy)
    shutil.rmtree(copy / "cube-single/gcivl/0")
    logs = {path: path.read_bytes() for path in (copy / "logs/cube-single").rglob("*.log")}
    cli.run(["suite", str(file), "--out", str(copy), "--jobs", "1"])
    assert states(copy, capsys) == dict.fromkeys(CELLS, "done")
    changed = {path for path, content in logs.items() if path.read_bytes() != content}
    assert changed == {copy / "logs/cube-single/gcivl/0.log"}


def test_a_suite_may_train_longer(out, tmp_path, capsys):
    copy, longer = tmp_path / "copy", tmp_path / "longer.toml"
    shutil.copytree(out, copy)
    shutil.rmtree(copy / "cube-single/gcivl/0")
    longer.write_text(TINY.replace("steps = 6", "steps = 8").replace('"gcbc", "gcivl"', '"gcbc"'))
    cli.run(["suite", str(longer), "--out", str(copy), "--jobs", "1"])
    assert states(copy, capsys) == {"gcbc/0": "done"}
    assert (copy / "cube-single/gcbc/0/checkpoints/8").is_dir()


def test_a_suite_may_grow_but_not_change(out, file, tmp_path):
    other = tmp_path / "other.toml"
    for old, new, complaint in (
        ("every = 3", "every = 2", r"evaluation\.every is 3 there and 2 now"),
        ("steps = 6", "steps = 5", r"gcbc/0 was made .*steps is 6 there and 5 now"),
    ):
        other.write_text(TINY.replace(old, new))
        with pytest.raises(UserError, match=complaint):
            cli.run(["suite", str(other), "--out", str(out)])


def test_a_dry_run_does_nothing_but_tell(file, tmp_path, capsys):
    cli.run(["suite", str(file), "--out", str(tmp_path / "new"), "--dry-run", "--jobs", "3"])
    told = capsys.readouterr().out
    assert all(f"cube-single/{cell}" in told for cell in CELLS)
    assert "3 at once shorten that by a factor of at most 3" in told
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ('"gcbc"', '"gcbb"', "unknown method 'gcbb'"),
        ('"cube-single"', '"cube-singel"', "unknown environment 'cube-singel'"),
        ("batch_size", "bach_size", r"--agent\.bach-size"),
        ("batch_size = 8", "batch_size = 0", "batch_size is 0"),
    ],
)
def test_what_no_cell_could_run_with_is_said_at_once(tmp_path, old, new, complaint):
    file = tmp_path / "bad.toml"
    file.write_text(TINY.replace(old, new))
    with pytest.raises(UserError, match=complaint):
        cli.run(["suite", str(file), "--out", str(tmp_path / "out"), "--dry-run"])
