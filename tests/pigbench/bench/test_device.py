"""The whole command on the CPU, tiny; what it keeps, and goes on from."""

import json

import pytest

from pigbench import cli
from pigbench.bench import simulation
from pigbench.errors import UserError

TINY = {
    "environments": "cube-single",
    "engines": "mujoco",
    "simulations": "2",
    "generation": "2",
    "episodes": "1",
    "picks": "1",
    "methods": "gcbc",
    "seeds": "",
    "cpu-seeds": "1 2",
    "precisions": "",
    "seconds": "0.01",
}


def bench(out, minutes):
    """The rows of the command, by name."""
    sizes = [word for name, value in TINY.items() for word in [f"--sizes.{name}", *value.split()]]
    cli.run(["bench", "device", "--out", str(out), "--minutes", str(minutes), *sizes])
    return {row["row"]: row for row in json.loads((out / "device.json").read_text())["rows"]}


def test_rows_are_kept_tabled_and_drawn_and_another_run_goes_on(tmp_path, monkeypatch, capsys):
    def broken(*_, **__):
        raise RuntimeError("RESOURCE_EXHAUSTED: no room")

    monkeypatch.setattr(simulation, "generation", broken)
    skipped = bench(tmp_path, 0.001)
    assert skipped["steps cube-single mujoco exact, 2"]["skipped"] == "no time left"
    rows = bench(tmp_path, 60)
    assert list(rows) == list(skipped)
    assert rows.pop("generation cube-single mujoco exact, 2")["failed"].endswith("no room")
    assert rows.pop("parity cube-single mujoco exact, 1")["placed"] == 1.0
    for row in rows.values():
        assert row["rate"] > 0
        assert row["jax_mb"] is row["card_mb"] is None  # as there is no card
    text = (tmp_path / "device.md").read_text()
    assert "- generation cube-single mujoco exact, 2: failed: RuntimeError" in text
    assert "| gcbc   |    cpu |   default |     2 |" in text
    assert (tmp_path / "device.png").read_bytes().startswith(b"\x89PNG")

    capsys.readouterr()
    assert bench(tmp_path, 60).items() >= rows.items()
    assert len(capsys.readouterr().out.splitlines()) == 1  # there was nothing left to do


def test_results_of_another_machine_are_not_kept(tmp_path):
    bench(tmp_path, 0.001)
    path = tmp_path / "device.json"
    content = json.loads(path.read_text())
    content["accelerator"]["kind"] = "another"
    for row in content["rows"]:
        row["failed"] = row.pop("skipped")
    path.write_text(json.dumps(content))
    assert all("skipped" in row for row in bench(tmp_path, 0.001).values())


def test_there_must_be_time(tmp_path):
    with pytest.raises(UserError, match=r"minutes is 0\.0: it must be more than 0"):
        bench(tmp_path, 0)
