"""A robot's log, made of an arm that moves as told."""

import csv
from pathlib import Path

import numpy as np
import pytest

HZ, SECONDS = 100, 2.0


def good_table(hz: int = HZ) -> dict[str, np.ndarray]:
    """Joints swing about a pose over the table, the gripper shuts half-way, the cube lies."""
    time = np.arange(int(SECONDS * hz) + 1) / hz
    rest = np.array([-1.3, -1.7, 1.9, -1.8, -1.5708, 0.3])
    swing = np.array([0.2, 0.1, -0.1, 0.05, 0.0, 0.3])
    columns = {"time": 1000.0 + time}
    for place in range(6):
        columns[f"joint_pos_{place}"] = rest[place] + swing[place] * np.sin(2 * time)
        columns[f"joint_vel_{place}"] = 2 * swing[place] * np.cos(2 * time)
    columns["gripper_opening"] = np.clip(time - 0.7, 0.0, 0.6)
    still = np.ones_like(time)
    pose = {"x": 0.05, "y": 0.42, "z": 0.02, "qw": np.cos(0.2), "qx": 0, "qy": 0, "qz": np.sin(0.2)}
    columns |= {f"object_{name}": value * still for name, value in pose.items()}
    return columns | {f"action_{place}": 0.1 * place * still for place in range(5)}


def write_csv(path: Path, table: dict[str, np.ndarray]) -> Path:
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(table)
        writer.writerows(zip(*table.values(), strict=True))
    return path


@pytest.fixture
def table():
    return good_table


@pytest.fixture
def write():
    return write_csv
