"""A small suite file."""

from pathlib import Path

import pytest

from pigbench.suite import spec
from pigbench.suite.spec import Suite

TEXT = """
preset = "cpu"
methods = ["gcivl", "h-flow-gcivl"]
seeds = [0, 3]

[agent]
learning_rate = 1e-3

[data]
policy = "play"
validation_episodes = 2

[evaluation]
every = 5_000
episodes = 20

[[environments]]
name = "cube-single"
transitions = 1_500
steps = 20_000

[[environments]]
name = "cube-double"
transitions = 100_000
steps = 40_000
data = "elsewhere/double"
"""


@pytest.fixture
def write(tmp_path):
    """`write(text)`: a suite file with that text."""

    def write(text: str = TEXT) -> Path:
        path = tmp_path / "suite.toml"
        path.write_text(text)
        return path

    return write


@pytest.fixture
def suite(write) -> Suite:
    return spec.read(write())
