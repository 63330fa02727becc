import json
import re

import pytest

from pigbench import cli
from pigbench.errors import UserError

FAST = ["--turns.turns", "1", "--turns.seconds", "0.01"]


def test_the_updates_of_methods_are_timed_and_saved(tmp_path, capsys):
    file = tmp_path / "train.json"
    cli.run(["bench", "train", "gcbc", "gciql", *FAST, "--json", str(file)])
    table = capsys.readouterr().out
    assert re.search(r"\| gcbc +\| +[\d.]+ \| +1\.00 \|", table)
    saved = json.loads(file.read_text())
    assert list(saved["seconds"]) == ["gcbc", "gciql"]
    assert saved["settings"]["preset"] == "cpu"
    assert {"versions", "machine", "commit"} <= set(saved)


def test_bad_input_is_refused():
    with pytest.raises(UserError, match="unknown method 'gcb'"):
        cli.run(["bench", "train", "gcb"])
    with pytest.raises(UserError, match="turns is 0: it must be at least 1"):
        cli.run(["bench", "train", "gcbc", "--turns.turns", "0"])
