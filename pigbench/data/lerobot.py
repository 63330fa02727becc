"""LeRobot's data set format, version 3: Parquet and JSON, written with pyarrow alone.

data/chunk-000/file-000.parquet           frames, one row group per episode; here one file per shard
meta/info.json                            sizes, splits, and the features of a frame
meta/stats.json                           minimum, maximum, mean and deviation of each feature
meta/tasks.parquet                        the tasks' texts: here only one, since play has no tasks
meta/episodes/chunk-000/file-000.parquet  each episode's location and its own statistics

A whole observation is stored as `observation.state`; a frame is one of our rows.
"""

import itertools
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Shaped

from pigbench.data.dataset import Dataset, Split
from pigbench.envs.units import ACTION_NAMES, ACTION_SIZE, CONTROL_STEP
from pigbench.errors import UserError
from pigbench.support import files, lock
from pigbench.support.extras import required
from pigbench.support.progress import Progress

VERSION = "v3.0"
CHUNK_SIZE = 1000  # files per folder
DATA_PATH = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
EPISODES_PATH = "meta/episodes/chunk-000/file-000.parquet"
TASKS_PATH = "meta/tasks.parquet"

_RATE = round(1 / CONTROL_STEP)  # frames per second

Columns = Mapping[str, Shaped[np.ndarray, "time ..."]]  # of one episode
LeRobotStatistics = Mapping[str, Mapping[str, list[Any]]]  # by column, then by name


def write(dataset: Dataset, path: Path) -> list[Path]:
    """Write the data set to the new folder `path`, completely or not at all, and return `[path]`.

    Raises UserError if `path` already exists or pyarrow is not installed.
    """
    pa, pq = required("pyarrow", "pyarrow.parquet", extra="share")
    files.require_new_folder(path)
    splits = dataset.splits
    shards = itertools.chain.from_iterable(map(_shards, splits.values()))
    total = sum(split.rows for split in splits.values())
    task = f"{dataset.spec.policy} data of {dataset.spec.environment}: any state may be the goal"
    records: list[dict[str, Any]] = []
    with (
        lock.replacing_folder(path) as new,
        Progress("export", total=total, unit="frames") as progress,
    ):
        for number, shard in enumerate(shards):
            where = {"chunk_index": number // CHUNK_SIZE, "file_index": number % CHUNK_SIZE}
            file = _path(new, DATA_PATH.format(**where))
            with pq.ParquetWriter(file, _schema(pa, dataset)) as writer:
                for episode in shard:
                    first = records[-1]["dataset_to_index"] if records else 0
                    columns = _columns(episode, number=len(records), first=first)
                    writer.write_table(_table(pa, columns, _schema(pa, dataset)))
                    records.append(_record(columns, where, task))
                    progress.advance(len(columns["index"]))
        pq.write_table(
            pa.Table.from_pylist([_flat(record) for record in records]), _path(new, EPISODES_PATH)
        )
        pq.write_table(_tasks(pa, task), _path(new, TASKS_PATH))
        files.write_json(_path(new, "meta/info.json"), _info(dataset, splits, records))
        files.write_json(_path(new, "meta/stats.json"), _pooled([r["stats"] for r in records]))
    return [path]


def _shards(split: Split) -> Iterator[Iterator[Columns]]:
    return (split.shard_episodes(record, "observations", "actions") for record in split.records)


def _path(folder: Path, name: str) -> Path:
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    return folder / name


def _columns(episode: Columns, *, number: int, first: int) -> Columns:
    """The columns of episode `number`, whose first frame has the index `first` overall."""
    frames = np.arange(len(episode["actions"]))
    return {
        "observation.state": np.asarray(episode["observations"]),
        "action": np.asarray(episode["actions"]),
        "timestamp": (frames / _RATE).astype(np.float32),
        "frame_index": frames,
        "episode_index": np.full_like(frames, number),
        "index": first + frames,
        "task_index": np.zeros_like(frames),
    }


def _features(dataset: Dataset) -> dict[str, dict[str, Any]]:
    """The features of a frame, as listed in `info.json`."""
    terms = [
        f"{name}_{number}" if size > 1 else name
        for name, size in dataset.layout.terms
        for number in range(size)
    ]
    return {
        "observation.state": {"dtype": "float32", "shape": [len(terms)], "names": terms},
        "action": {"dtype": "float32", "shape": [ACTION_SIZE], "names": [*ACTION_NAMES]},
        "timestamp": {"dtype": "float32", "shape": [1], "names": None},
        **{
            name: {"dtype": "int64", "shape": [1], "names": None}
            for name in ("frame_index", "episode_index", "index", "task_index")
        },
    }


def _schema(pa: Any, dataset: Dataset) -> Any:
    """The types of the columns: fixed-size lists where there is more than one number."""
    kinds = {"float32": pa.float32(), "int64": pa.int64()}
    return pa.schema(
        {
            name: kinds[feature["dtype"]]
            if feature["shape"] == [1]
            else pa.list_(kinds[feature["dtype"]], feature["shape"][0])
            for name, feature in _features(dataset).items()
        }
    )


def _table(pa: Any, columns: Columns, schema: Any) -> Any:
    arrays = [
        pa.FixedSizeListArray.from_arrays(np.ravel(columns[field.name]), type=field.type)
        if columns[field.name].ndim > 1
        else pa.array(columns[field.name], type=field.type)
        for field in schema
    ]
    return pa.Table.from_arrays(arrays, schema=schema)


def _record(columns: Columns, where: Mapping[str, int], task: str) -> dict[str, Any]:
    """An episode's entry in `meta/episodes`."""
    index = columns["index"]
    return {
        "episode_index": int(columns["episode_index"][0]),
        "tasks": [task],
        "length": len(index),
        "dataset_from_index": int(index[0]),
        "dataset_to_index": int(index[-1]) + 1,
        "data/chunk_index": where["chunk_index"],
        "data/file_index": where["file_index"],
        "meta/episodes/chunk_index": 0,
        "meta/episodes/file_index": 0,
        "stats": {name: _statistics(values) for name, values in columns.items()},
    }


def _statistics(values: Shaped[np.ndarray, "time ..."]) -> dict[str, list[Any]]:
    rows = values.reshape(len(values), -1)
    exact = rows.astype(np.float64)
    return {
        "min": rows.min(axis=0).tolist(),
        "max": rows.max(axis=0).tolist(),
        "mean": exact.mean(axis=0).tolist(),
        "std": exact.std(axis=0).tolist(),
        "count": [len(rows)],
    }


def _pooled(several: Sequence[LeRobotStatistics]) -> dict[str, dict[str, list[Any]]]:
    """Statistics of all frames, computed from those of the episodes."""

    def pool(name: str) -> dict[str, list[Any]]:
        of = {key: np.array([one[name][key] for one in several]) for key in several[0][name]}
        share = of["count"] / of["count"].sum()
        mean = (share * of["mean"]).sum(axis=0)
        variance = (share * (of["std"] ** 2 + (of["mean"] - mean) ** 2)).sum(axis=0)
        return {
            "min": of["min"].min(axis=0).tolist(),
            "max": of["max"].max(axis=0).tolist(),
            "mean": mean.tolist(),
            "std": np.sqrt(variance).tolist(),
            "count": [int(of["count"].sum())],
        }

    return {name: pool(name) for name in several[0]}


def _flat(record: Mapping[str, Any]) -> dict[str, Any]:
    """The record with its statistics as columns, `stats/action/mean`."""
    plain = {name: value for name, value in record.items() if name != "stats"}
    return plain | {
        f"stats/{name}/{key}": values
        for name, statistics in record["stats"].items()
        for key, values in statistics.items()
    }


def _tasks(pa: Any, task: str) -> Any:
    """The table of tasks, with their texts as pandas's index, by which readers look them up."""
    columns = [("task_index", "int64", "int64"), ("task", "unicode", "object")]
    pandas = {
        "index_columns": ["task"],
        "column_indexes": [],
        "columns": [
            {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": numpy_kind}
            | {"metadata": None}
            for name, kind, numpy_kind in columns
        ],
        "pandas_version": "2.0.0",
    }
    table = pa.table({"task_index": pa.array([0], pa.int64()), "task": [task]})
    return table.replace_schema_metadata({"pandas": json.dumps(pandas)})


def _info(
    dataset: Dataset, splits: Mapping[str, Split], records: Sequence[Mapping[str, Any]]
) -> dict[str, Any]:
    counts = [sum(part.episodes for part in split.records) for split in splits.values()]
    bounds = np.cumsum([0, *counts])
    if bounds[-1] != len(records):
        raise UserError(
            f"{dataset.folder} is invalid: its terminals do not end {bounds[-1]} episodes"
        )
    return {
        "codebase_version": VERSION,
        "robot_type": "ur5e",
        "total_episodes": len(records),
        "total_frames": records[-1]["dataset_to_index"],
        "total_tasks": 1,
        "chunks_size": CHUNK_SIZE,
        "data_files_size_in_mb": 100,
        "video_files_size_in_mb": 500,
        "fps": _RATE,
        "splits": {
            name: f"{start}:{stop}"
            for name, (start, stop) in zip(splits, itertools.pairwise(bounds), strict=True)
        },
        "data_path": DATA_PATH,
        "video_path": None,
        "features": _features(dataset),
    }
