"""States of OGBench's play for the MJX engines, in each situation that they are held to."""

import numpy as np
import pytest


@pytest.fixture(scope="module")
def situations(play):
    """A state and control of OGBench's play in each situation: qpos, qvel (3, ...), ctrl (3, 7)."""
    recording = play("cube-double", 1500)
    gripped, free = recording.contact > 0.5, recording.contact == 0
    carried = recording.qpos[:, [16, 23]].max(axis=1) > 0.05
    rows = [
        np.flatnonzero(free & ~recording.stacked)[50],
        np.flatnonzero(gripped & carried & ~recording.stacked)[10],
        np.flatnonzero(free & recording.stacked)[10],
    ]
    columns = (recording.qpos, recording.qvel, recording.ctrl)
    return tuple(np.float32(column[rows]) for column in columns)
