"""One recording of OGBench's play, made once."""

import pytest

from pigbench.fidelity import recording
from pigbench.fidelity.recording import Recording

STEPS = 300


@pytest.fixture(scope="session")
def recordings() -> list[Recording]:
    return recording.record("cube-double", "play", episodes=1, steps=STEPS, seed=0)
