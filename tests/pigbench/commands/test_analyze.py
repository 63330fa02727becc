"""What `analyze` and `subgoals` tell of a run: that of a hierarchy, which has both."""

import dataclasses

import pytest

from pigbench import cli, envs
from pigbench.envs.reality import Reality


@pytest.fixture(scope="module")
def folders(played, short_episodes, tmp_path_factory):
    """A data set and a run on it."""
    run = tmp_path_factory.mktemp("analysis") / "run"
    train = ["train", "h-flow-gcivl", "--data", str(played), "--out", str(run), "--preset", "cpu"]
    small = ["--steps", "2", "--evaluation.episodes", "1", "--agent.candidates", "2"]
    networks = [("value", "agent"), ("actor", "agent"), ("value", "agent.low")]
    sizes = [text for kind, part in networks for text in (f"--{part}.{kind}-hidden-sizes", "8")]
    with short_episodes():
        cli.run([*train, *small, *sizes])
    return played, run


def cells(printed):
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in printed.splitlines()]


def test_residuals_are_told_by_contact_mode(folders, capsys):
    data, run = folders
    cli.run(["analyze", str(run), "--data", str(data), "--samples", "500"])
    printed = capsys.readouterr().out
    assert (run / "analysis/residuals.md").read_text() in printed
    assert (run / "analysis/residuals.png").stat().st_size > 10_000
    shares = [float(row[1]) for row in cells(printed)[2:5] if row]
    assert sum(shares) == pytest.approx(100, abs=0.2)


def test_the_datas_own_actions_lead_to_its_states_and_an_untrained_policy_does_not(folders, capsys):
    data, run = folders
    cli.run(["subgoals", str(run), "--data", str(data), "--samples", "40"])
    printed = capsys.readouterr().out
    assert (run / "analysis/subgoals.md").read_text() in printed
    rows = [row for row in cells(printed)[2:] if row]
    replayed, led = (
        [float(row[3]) for row in rows if row[2] == way]
        for way in ("the data's actions", "low level, fixed subgoal")
    )
    assert max(replayed) < 1  # mm; from its states in single precision
    assert min(led) > 20
    right, drawn = (float(row[2]) for row in rows if row[0] in ("the data's subgoal", "generated"))
    assert right < 20 < drawn  # mm; a held cube is nearer


def test_what_data_do_not_record_of_an_environment_is_not_simulated(folders, monkeypatch):
    data, run = folders
    arguments = ["subgoals", str(run), "--data", str(data), "--samples", "4"]
    spec = envs.SPECS["cube-single"]
    late = dataclasses.replace(spec, reality=Reality(action_delay=1))
    monkeypatch.setitem(envs.SPECS, "cube-single", late)
    with pytest.raises(cli.UserError, match=r"cube-single delays actions, .* without a reality"):
        cli.run(arguments)
    monkeypatch.setitem(envs.SPECS, "cube-single", dataclasses.replace(spec, reality=Reality()))
    cli.run(arguments)


@pytest.mark.parametrize("command", ["analyze", "subgoals"])
def test_an_impossible_number_of_samples_is_refused(folders, command):
    data, run = folders
    with pytest.raises(cli.UserError, match="samples is 0: it must be at least 1"):
        cli.run([command, str(run), "--data", str(data), "--samples", "0"])
    with pytest.raises(cli.UserError, match=r"samples take .* choose fewer"):
        cli.run([command, str(run), "--data", str(data), "--samples", "9" * 20])
