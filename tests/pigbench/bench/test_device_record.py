"""What is kept of measurements, by rows made by hand."""

import json

from pigbench.bench import device_record
from pigbench.bench.budget import RATE, TOOK, Row

ORIGIN = {
    "sizes": {"simulations": (2,)},
    "versions": {"jax": "1"},
    "machine": {"cpu_count": 2},
    "accelerator": {"kind": "cpu", "nvidia": None},
}
LABELS = {"what": "training", "method": "gcbc", "preset": "cpu", "precision": "default", "size": 1}
DONE, NEXT = (Row("", f"gcbc {n}", 1, LABELS, dict, 1.0) for n in ("a", "b"))
RESULTS = {DONE.name: {RATE: 5.0, TOOK: 1.5}}


def test_results_come_back_on_the_same_machine_only(tmp_path):
    assert device_record.earlier(tmp_path, ORIGIN) == {}
    entries = device_record.entries([DONE, NEXT], RESULTS)
    assert entries == [{"row": "gcbc a, 1", **LABELS, RATE: 5.0, TOOK: 1.5}]
    device_record.keep(tmp_path, ORIGIN, entries)
    earlier = device_record.earlier(tmp_path, ORIGIN)
    assert list(earlier) == [DONE.name]
    assert earlier[DONE.name].items() >= RESULTS[DONE.name].items()
    assert device_record.earlier(tmp_path, ORIGIN | {"versions": {"jax": "2"}}) == {}


def test_both_files_are_written(tmp_path):
    device_record.keep(tmp_path, ORIGIN, device_record.entries([DONE, NEXT], RESULTS))
    assert list(json.loads((tmp_path / "device.json").read_text())) == [*ORIGIN, "rows"]
    assert "| gcbc   |    cpu |   default |     1 |" in (tmp_path / "device.md").read_text()
