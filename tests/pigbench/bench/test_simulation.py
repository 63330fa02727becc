import importlib
import json

import pytest

from pigbench import cli
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
