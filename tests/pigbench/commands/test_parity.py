"""`pigbench parity` and `pigbench parity data`, as their users run them."""

import json

import pytest

from pigbench import cli
from pigbench.commands import parity
from pigbench.errors import UserError


@pytest.fixture(autouse=True)
def short_episodes(monkeypatch):
    monkeypatch.setattr(parity, "_EPISODE_LENGTH", 200)


def test_errors_and_outcomes_are_tabled(tmp_path, capsys):
    file = tmp_path / "parity.json"
    cli.run(["parity", "cube-single", "--episodes", "1", "--physics", "fast", "--json", str(file)])
    printed = capsys.readouterr().out
    assert "| mujoco |    fast |" in printed
    kept = json.loads(file.read_text())
    assert kept["settings"]["environment"] == "cube-single"
    header, *lines = kept["errors"]
    assert {(line[2], line[3]) for line in lines} >= {("free", "1"), ("carrying", "50")}
    windows = [int(line[header.index("windows")]) for line in lines if line[3] == "50"]
    assert sum(windows) == 4
    assert kept["outcomes"][1][2:] == ["2", "100.0 %", "100.0 %"]


def test_data_are_compared_quantity_by_quantity(tmp_path, capsys):
    cli.run(["parity", "data", "cube-single", "--policies", "play", "--episodes", "2"])
    lines = [line.split("|") for line in capsys.readouterr().out.splitlines() if "|" in line]
    assert [cell.strip() for cell in lines[0]][1:4] == ["quantity", "policy", "ogbench"]
    durations = next(line for line in lines if "duration" in line[1])
    assert all(80 < float(cell) < 100 for cell in durations[3:5])


@pytest.mark.parametrize("command", ["parity", "parity data", "parity policy any"])
def test_no_episodes(command):
    with pytest.raises(UserError, match="episodes is 0: it must be at least 1"):
        cli.run([*command.split(), "--episodes", "0"])
