import shutil

import pytest

from pigbench.errors import UserError
from pigbench.page import entries
from pigbench.support.lock import only_writer


def test_a_run_is_done_when_it_is_evaluated_at_its_end(runs, make_run, tmp_path):
    half = make_run(tmp_path / "half", {0: [[0]], 100: [[1, 0]]}).path
    with only_writer(half):
        done, running = entries.read([runs[0], half])
    assert (done.state, done.done, done.success) == ("done", True, 50.0)
    assert (running.state, running.steps, running.total) == ("running", 100, 200)
    (cut_off,) = entries.read([half])
    assert (cut_off.state, cut_off.done, cut_off.success) == ("cut off", False, 50.0)
    assert cut_off.result.last_step == 100


def test_a_run_without_evaluation_is_no_error(runs):
    (runs[0] / "episodes.csv").unlink()
    (begun,) = entries.read(runs[:1])
    assert (begun.steps, begun.success, begun.result) == (0, None, None)
    assert begun.saved.run.config.method == "gcivl"


def test_a_suite_is_all_its_cells(suite):
    found = {entry.name: entry for entry in entries.read([suite])}
    assert {name: (entry.state, entry.success) for name, entry in found.items()} == {
        "cube-single/gcivl/0": ("done", 100.0),
        "cube-single/hjb-gcivl/0": ("cut off", 100.0),
        "cube-single/gcivl/1": ("cut off", None),
        "cube-single/hjb-gcivl/1": ("waiting", None),
    }
    assert [entry.result is not None for entry in found.values()] == [True, True, False, False]


def test_what_is_neither_run_nor_suite_is_named(tmp_path, runs):
    with pytest.raises(UserError, match="is not a run"):
        entries.read([tmp_path])
    shutil.copy(runs[0] / "config.json", runs[0] / "episodes.csv")
    with pytest.raises(UserError, match="is invalid: its columns"):
        entries.read(runs)
