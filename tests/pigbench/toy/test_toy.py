"""`pigbench toy` end to end with few updates, and what it says to bad input."""

import csv
import json
import sys

import numpy as np
import pytest
from PIL import Image

from pigbench import cli

FEW = ["--settings.steps", "3", "--settings.batch-size", "4", "--settings.hidden-sizes", "4"]
ROWS = {"hybrid": ["no contact", "holding"], "anisotropy": [f"speeds {r} : 1" for r in (1, 2, 4)]}
FILES = {"errors.csv", "errors.md", "toy.json"} | {
    f"{name}.{extension}" for name in ("figure", "extended") for extension in ("png", "pdf")
}


def toy(out, example):
    seeds = ["--seeds", "2", "--seed", "7"]
    cli.run(["toy", "--out", str(out), "--example", example, *seeds, *FEW])


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """The results of each example."""
    made = {example: tmp_path_factory.mktemp("toy") / "new" / example for example in ROWS}
    for example, folder in made.items():
        toy(folder, example)
    return made


@pytest.mark.parametrize("example", ROWS)
def test_table_figures_and_settings_are_written(example, folders):
    out = folders[example]
    assert {path.name for path in out.iterdir()} == FILES
    with open(out / "errors.csv") as file:
        rows = list(csv.DictReader(file))
    assert list(dict.fromkeys(row["mode"] for row in rows)) == ROWS[example]
    assert list(dict.fromkeys(row["loss"] for row in rows)) == ["baseline", "hjb", "eikonal"]
    assert {row["seeds"] for row in rows} == {"2"}
    kept = json.loads((out / "toy.json").read_text())
    assert kept["settings"]["example"] == example
    assert kept["settings"]["settings"]["steps"] == 3
    assert {"python", "jax", "pigbench"} <= kept["versions"].keys()
    assert np.asarray(Image.open(out / "figure.png").convert("L")).std() > 1
    assert (out / "extended.pdf").read_bytes().startswith(b"%PDF")


def test_the_same_seeds_give_the_same_bytes_and_the_table_is_printed(folders, tmp_path, capsys):
    toy(tmp_path, "hybrid")
    assert capsys.readouterr().out.startswith((tmp_path / "errors.md").read_text())
    for file in FILES - {"toy.json"}:  # which tells the state of the code
        assert (tmp_path / file).read_bytes() == (folders["hybrid"] / file).read_bytes(), file


WRONG = {
    "unknown example": (["--example", "hybird"], "did you mean 'hybrid'?"),
    "no seeds": (["--seeds", "0"], "seeds is 0: it must be at least 1"),
    "no steps": (["--settings.steps", "0"], "steps is 0: it must be at least 1"),
}


@pytest.mark.parametrize("arguments, says", WRONG.values(), ids=WRONG)
def test_bad_input_gets_one_clear_line_and_status_2(arguments, says, tmp_path, monkeypatch, capsys):
    command = ["pigbench", "toy", "--out", str(tmp_path / "toy"), *arguments]
    monkeypatch.setattr(sys, "argv", command)
    with pytest.raises(SystemExit) as stop:
        cli.main()
    error = capsys.readouterr().err
    assert stop.value.code == 2
    assert says in error
    assert error.startswith("pigbench: ")
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())
