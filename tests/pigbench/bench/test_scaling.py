"""Scaling: the table and the picture."""

import pytest

from pigbench import cli
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


@pytest.mark.parametrize("command", ["scale", "memory"])
def test_no_simulations(command):
    with pytest.raises(UserError, match="simulations is 0: it must be at least 1"):
        cli.run(["bench", command, "cube-single", "--simulations", "0"])
