"""One recording of OGBench's play, made once."""

import pytest

from pigbench.fidelity import recording
from pigbench.fidelity.recording import PeerRecording

STEPS = 300


@pytest.fixture(scope="session")
def recordings() -> list[PeerRecording]:
    return recording.record("cube-double", "play", episodes=1, steps=STEPS, seed=0)
