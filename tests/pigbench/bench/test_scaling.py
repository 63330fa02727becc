"""Scaling: the table, the picture, and memory against the sizes of what goes in and out."""

import pytest

from pigbench import cli, envs
from pigbench.bench import scaling
from pigbench.errors import UserError


def test_batches_and_environments_are_timed_and_drawn(tmp_path, capsys):
    picture = tmp_path / "scaling.png"
    options = "--simulations 1 3 --environments cube-single cube-double --batch 3 --physics fast"
    turns = "--turns.turns 1 --turns.seconds 0.01 --out"
    cli.run(["bench", "scale", "cube-single", *options.split(), *turns.split(), str(picture)])
    lines = capsys.readouterr().out.splitlines()
    names = [line.split("|")[1].strip() for line in lines if line.startswith("| cube")]
    assert names == ["cube-single, 1", "cube-single, 3", "cube-double, 3"]
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_what_goes_in_and_out_is_counted():
    env = envs.make("cube-single")
    # qpos 21, qvel 20, warm start 20, pinch 3 and 1, force 1 in four bytes each, and two flags.
    state = 4 * (21 + 20 + 20 + 3 + 1 + 1) + 2
    for count in (1, 8):
        size = scaling.footprint(env, count)
        assert size.arguments == count * (state + 4 * env.action_size)
        assert size.results >= count * state
        assert size.total == size.arguments + size.results + size.temporary


def test_memory_is_tabled(capsys):
    cli.run(["bench", "memory", "cube-single", "--engine", "mujoco", "--simulations", "2", "4"])
    lines = [line.split("|") for line in capsys.readouterr().out.splitlines() if "mujoco" in line]
    assert [line[2].strip() for line in lines] == ["2", "4"]


@pytest.mark.parametrize("command", ["scale", "memory"])
def test_no_simulations(command):
    with pytest.raises(UserError, match="simulations is 0: it must be at least 1"):
        cli.run(["bench", command, "cube-single", "--simulations", "0"])
