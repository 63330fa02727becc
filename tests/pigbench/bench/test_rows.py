import json
import re

from pigbench import cli
from pigbench.bench import throwaway


def test_both_homes_of_rows_are_timed_and_nothing_is_left(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(throwaway, "EPISODE_ROWS", 21)
    (tmp_path / "scratch").mkdir()
    cli.run(
        [
            *("bench", "rows", "--transitions", "1990", "--folder", str(tmp_path / "scratch")),
            *("--turns.turns", "1", "--turns.seconds", "0.01", "--json", str(tmp_path / "r.json")),
        ]
    )
    out = capsys.readouterr().out
    assert out.startswith("2,100 rows, 0.0 GB, a few simulated episodes repeated; auto")
    assert re.search(r"\| disk +\| +[\d.]+ \| +[\d.]+ \| +[\d.]+ \| +[\d.]+ \|", out)
    saved = json.loads((tmp_path / "r.json").read_text())
    assert list(saved["seconds"]) == list(saved["opened"]) == ["device", "disk"]
    assert all(2e8 < size < 4e9 for size in saved["resident"].values())
    assert list((tmp_path / "scratch").iterdir()) == []
