import json
import re
from pathlib import Path

import jaxlib
import numpy as np
import pytest

from pigbench import cli
from pigbench.bench import rows, throwaway


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
    assert list(saved["resident"]) == ["device", "disk"]
    assert list((tmp_path / "scratch").iterdir()) == []


def test_resident_memory_is_what_a_process_holds_without_pages_of_files():
    libraries = Path(jaxlib.__file__).parent.rglob("*.so")
    file = np.memmap(max(libraries, key=lambda path: path.stat().st_size), np.uint8, mode="r")
    assert file.nbytes > 10**8
    before = rows._resident()
    assert file.max() == 255  # reads every page
    assert abs(rows._resident() - before) < 0.1 * file.nbytes
    held = np.ones(file.nbytes, np.uint8)
    assert rows._resident() - before == pytest.approx(held.nbytes, rel=0.1)
