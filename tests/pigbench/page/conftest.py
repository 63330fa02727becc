"""Runs of two methods in two environments, and a suite under way."""

from pathlib import Path

import pytest

from pigbench.suite import spec

SUITE = """
methods = ["gcivl", "hjb-gcivl"]
seeds = [0, 1]
evaluation.every = 100
environments = [{name = "cube-single", transitions = 1_000, steps = 200}]
"""


@pytest.fixture
def runs(tmp_path, make_run) -> list[Path]:
    """GCIVL with two seeds, 50 and 100 % of the last episodes, and HJB-GCIVL with one."""
    rates = {
        ("gcivl", "cube-single", 0): [[1, 0], [1, 0]],
        ("gcivl", "cube-single", 1): [[1, 1], [1, 1]],
        ("hjb-gcivl", "cube-single", 0): [[1, 1], [0, 0]],
        ("hjb-gcivl", "cube-double", 0): [[0, 0], [0, 1]],
    }
    return [
        make_run(
            tmp_path / environment / method / str(seed),
            {0: [[0, 0], [0, 0]], 200: last},
            more={"touched": True, "lifted": False},
            method=method,
            environment=environment,
            seed=seed,
        ).path
        for (method, environment, seed), last in rates.items()
    ]


@pytest.fixture
def suite(tmp_path, make_run) -> Path:
    """A suite with one cell done, one cut off half-way, one of an alien folder, one to come."""
    (tmp_path / "suite.toml").write_text(SUITE)
    out = tmp_path / "small"
    out.mkdir()
    spec.write(out / spec.KEPT, spec.read(tmp_path / "suite.toml"))
    done = make_run(out / "cube-single/gcivl/0", {0: [[0]], 200: [[1]]})
    (done.checkpoints_path / "200").mkdir(parents=True)
    make_run(out / "cube-single/hjb-gcivl/0", {0: [[0]], 100: [[1]]}, method="hjb-gcivl")
    (out / "cube-single/gcivl/1").mkdir()
    (out / "cube-single/gcivl/1/config.json").write_text("{}")
    return out
