import dataclasses
import json

from pigbench.agents import Statistics
from pigbench.runs import run as runs
from pigbench.runs.history import record_resumption

STATISTICS = Statistics.standard(1)


def test_what_a_run_goes_on_with_is_kept_where_it_is_something_else(tmp_path, config):
    def made(jax, commit="abc", command="train"):
        return {"versions": {"jax": jax, "mujoco": "3"}, "commit": commit, "command": command}

    def resume(step, origin):
        return record_resumption(tmp_path / "provenance.json", origin, step=step)

    def kept():
        return json.loads((tmp_path / "provenance.json").read_text())

    runs.open_run(tmp_path, config, made("1"), STATISTICS)
    assert resume(100, made("1", command="train again")) is None
    assert kept() == made("1")
    assert resume(100, made("2")) == "versions.jax was '1' and is '2'"
    assert resume(100, made("2")) is None
    assert resume(150, made("2", "def")) == "commit was 'abc' and is 'def'"
    assert kept() == made("1") | {"resumed": {"100": made("2"), "150": made("2", "def")}}
    runs.open_run(tmp_path, dataclasses.replace(config, steps=400), made("3"), STATISTICS)
    assert resume(200, made("3")) is None  # it was told as the run was extended
    assert resume(200, made("1")) == "versions.jax was '3' and is '1'"
