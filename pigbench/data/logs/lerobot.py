"""Episodes of a UR5e's LeRobot v3 folder: its Parquet files as tables of our columns.

The names in `meta/info.json` identify a feature's elements: one of our names, or one of `ALIASES`,
which are those of the drivers of the UR5e and of Robotiq's gripper. Images are left out.
"""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pigbench.data.lerobot import VERSION
from pigbench.data.logs import tables
from pigbench.data.logs.columns import LogTable
from pigbench.errors import UserError
from pigbench.support import files

INFO = Path("meta", "info.json")

_JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
_STATE: Mapping[str, str] = {
    **{f"{joint}_joint": f"joint_pos_{place}" for place, joint in enumerate(_JOINTS)},
    **{f"{joint}_joint.pos": f"joint_pos_{place}" for place, joint in enumerate(_JOINTS)},
    **{f"{joint}_joint.vel": f"joint_vel_{place}" for place, joint in enumerate(_JOINTS)},
    "gripper": "gripper_opening",
    "gripper.pos": "gripper_opening",
}
_OBJECT = {name: f"object_{name}" for name in ("x", "y", "z", "qw", "qx", "qy", "qz")}
_TARGET = {name: f"target_{name}" for name in ("x", "y", "z", "yaw")} | {
    "gripper": "target_opening",
    "gripper.pos": "target_opening",
}
ALIASES: Mapping[str, Mapping[str, str]] = {
    "observation.state": _STATE,
    "observation.environment_state": _OBJECT,
    "action": _TARGET,
}
"""For each feature that is read, our column for each element's name."""


def is_dataset(path: Path) -> bool:
    """Whether a folder is a LeRobot data set."""
    return (path / INFO).is_file()


def files_of(folder: Path) -> list[Path]:
    """The files of a folder that are read."""
    return [folder / INFO, *sorted(folder.glob("data/chunk-*/*.parquet"))]


def read(folder: Path) -> Iterator[tuple[str, LogTable]]:
    """Yield the episodes of a data set in order, with names. Raises UserError if it is invalid."""
    info = files.read_json(folder / INFO)
    if info.get("codebase_version") != VERSION:
        raise UserError(
            f"{folder} has LeRobot's format {info.get('codebase_version')}: only {VERSION} is read"
        )
    if "ur5e" not in re.sub(r"[^a-z0-9]", "", str(info.get("robot_type")).lower()):
        raise UserError(f"{folder} is of a robot {info.get('robot_type')!r}: a UR5e's is read")
    names = {feature: _names(folder, info, feature) for feature in ALIASES}
    _, *paths = files_of(folder)
    if not paths:
        raise UserError(f"{folder} has no data/chunk-000/file-000.parquet")
    for path in paths:
        yield from _episodes(path, names)


def _names(folder: Path, info: Mapping[str, Any], feature: str) -> list[str]:
    """Our column for each element of a feature, or the element's own name."""
    description = info.get("features", {}).get(feature)
    if description is None:
        raise UserError(f"{folder / INFO} has no feature {feature}")
    names = description.get("names")
    if isinstance(names, Mapping):  # {"motors": [...]}
        names = [name for part in names.values() for name in part]
    if not names or len(names) != np.prod(description.get("shape", [])):
        raise UserError(f"{folder / INFO} does not name the elements of {feature}")
    return [ALIASES[feature].get(name, name) for name in names]


def _episodes(path: Path, names: Mapping[str, list[str]]) -> Iterator[tuple[str, LogTable]]:
    table = tables.parquet(path)
    missing = {"timestamp", "episode_index", *names} - set(table.column_names)
    if missing:
        raise UserError(f"{path} has no column {min(missing)}")
    numbers = table.column("episode_index").to_numpy()
    columns = {"time": table.column("timestamp").to_numpy().astype(float)}
    for feature, own in names.items():
        values = np.array(table.column(feature).to_pylist(), float)
        if values.shape != (len(numbers), len(own)):
            raise UserError(f"{path}: {feature} has shape {values.shape}, not {len(own)} per row")
        columns |= dict(zip(own, values.T, strict=True))
    for number in dict.fromkeys(numbers):
        own = numbers == number
        name = f"{path} episode {number}"
        yield name, {column: values[own] for column, values in columns.items()}
