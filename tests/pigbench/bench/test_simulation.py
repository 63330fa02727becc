import dataclasses
import importlib
import json

import pytest

from pigbench import cli, envs
from pigbench.bench import simulation
from pigbench.errors import UserError

FAST = ["--environment", "cube-single", "--turns.turns", "1", "--turns.seconds", "0.01"]


@pytest.mark.parametrize(
    "command", [("generate", "--simulations", "2"), ("evaluate", "--episodes", "1")]
)
def test_ours_is_timed_beside_ogbench(command, tmp_path, capsys):
    file = tmp_path / "bench.json"
    cli.run(["bench", *command, *FAST, "--physics", "fast", "--json", str(file)])
    table = capsys.readouterr().out.splitlines()
    names = [line.split("|")[1].strip() for line in table[2:] if "|" in line]
    alone = ["pigbench fast, engine alone"] if command[0] == "generate" else []
    assert names == ["ogbench", "pigbench fast", *alone]
    saved = json.loads(file.read_text())
    theirs, ours = (saved["seconds"][name]["seconds"][0] for name in ("ogbench", "pigbench fast"))
    assert float(table[3].split("|")[3]) == pytest.approx(theirs / ours, abs=0.06)


def test_the_peer_must_be_installed(monkeypatch):
    def missing(module):
        raise ImportError(module)

    monkeypatch.setattr(importlib, "import_module", missing)
    from pigbench.bench import peers

    with pytest.raises(UserError, match="ogbench package is not installed"):
        peers.generation("cube-single")


def test_an_evaluation_that_ends_early_tells_no_time(monkeypatch):
    spec = dataclasses.replace(envs.get("cube-single"), success_distance=10.0)
    monkeypatch.setattr(envs, "SPECS", {"cube-single": spec})
    env = envs.make("cube-single", profile="fast")
    contender = simulation.evaluation(env, 1, "gcbc", "cpu", name="ours")
    with pytest.raises(UserError, match="episodes of cube-single end early"):
        contender.work(1)
