"""LeRobot's format, against what its documentation and `LeRobotDataset` say of version 3."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from pigbench import cli
from pigbench.data import dataset
from pigbench.data.writer import Writer

pa = pytest.importorskip("pyarrow")
pq = pytest.importorskip("pyarrow.parquet")

# Of version 3: names, types and shapes, as `LeRobotDataset` has them.
FRAME = {
    "observation.state": pa.list_(pa.float32(), 9),
    "action": pa.list_(pa.float32(), 5),
    "timestamp": pa.float32(),
    "frame_index": pa.int64(),
    "episode_index": pa.int64(),
    "index": pa.int64(),
    "task_index": pa.int64(),
}
EPISODE = {
    "episode_index": pa.int64(),
    "tasks": pa.list_(pa.string()),
    "length": pa.int64(),
    "dataset_from_index": pa.int64(),
    "dataset_to_index": pa.int64(),
    "data/chunk_index": pa.int64(),
    "data/file_index": pa.int64(),
    "meta/episodes/chunk_index": pa.int64(),
    "meta/episodes/file_index": pa.int64(),
}
STATISTICS = {"min", "max", "mean", "std", "count"}


@pytest.fixture
def ours(tmp_path, spec, arrays) -> dataset.Dataset:
    """A data set whose second shard lost an episode."""
    writer = Writer(tmp_path / "data", dataclasses.replace(spec, versions={}))
    for part in writer.missing():
        dropped = int(part.name == "train-00001")
        writer.write(part, arrays(spec, part, dropped=dropped), dropped=dropped)
    return dataset.load(tmp_path / "data")


@pytest.fixture
def exported(ours, tmp_path) -> Path:
    out = tmp_path / "deep" / "lerobot"
    cli.run(["data", "export", str(ours.folder), "--format", "lerobot", "--out", str(out)])
    return out


def test_the_files_are_where_readers_look(exported):
    assert {str(path.relative_to(exported)) for path in exported.rglob("*.*")} == {
        *(f"data/chunk-000/file-{number:03d}.parquet" for number in range(4)),
        "meta/info.json",
        "meta/stats.json",
        "meta/tasks.parquet",
        "meta/episodes/chunk-000/file-000.parquet",
    }


def test_frames_are_our_rows_to_the_bit(ours, exported):
    files = sorted((exported / "data").rglob("*.parquet"))
    frames = pa.concat_tables([pq.read_table(file) for file in files])
    assert dict(zip(frames.schema.names, frames.schema.types, strict=True)) == FRAME
    for column, field in (("observation.state", "observations"), ("action", "actions")):
        rows = np.concatenate([ours.split(split).concatenate(field) for split in ("train", "val")])
        np.testing.assert_array_equal(np.stack(frames[column].to_numpy()), rows)
    assert frames["index"].to_pylist() == list(range(20))
    assert frames["episode_index"].to_pylist() == sorted([*range(5)] * 4)
    assert frames["frame_index"].to_pylist() == [0, 1, 2, 3] * 5
    np.testing.assert_allclose(frames["timestamp"].to_numpy()[:4], [0, 0.05, 0.1, 0.15])
    assert [pq.ParquetFile(file).num_row_groups for file in files] == [2, 1, 1, 1]


def test_episodes_tell_where_their_frames_lie(exported):
    table = pq.read_table(exported / "meta/episodes/chunk-000/file-000.parquet")
    types = dict(zip(table.schema.names, table.schema.types, strict=True))
    assert {name: types[name] for name in EPISODE} == EPISODE
    assert types.keys() - EPISODE.keys() == {
        f"stats/{feature}/{name}" for feature in FRAME for name in STATISTICS
    }
    info = json.loads((exported / "meta/info.json").read_text())
    for episode in table.to_pylist():
        place = {kind: episode[f"data/{kind}_index"] for kind in ("chunk", "file")}
        path = info["data_path"].format(chunk_index=place["chunk"], file_index=place["file"])
        index = pq.read_table(exported / path)["index"].to_pylist()
        own = list(range(episode["dataset_from_index"], episode["dataset_to_index"]))
        assert len(own) == episode["length"] == 4
        assert set(own) <= set(index)
    assert [episode["data/file_index"] for episode in table.to_pylist()] == [0, 0, 1, 2, 3]


def test_the_information_is_complete(exported):
    info = json.loads((exported / "meta/info.json").read_text())
    assert info["codebase_version"] == "v3.0"
    assert (info["total_episodes"], info["total_frames"], info["total_tasks"]) == (5, 20, 1)
    assert (info["fps"], info["chunks_size"], info["video_path"]) == (20, 1000, None)
    assert info["splits"] == {"train": "0:4", "val": "4:5"}
    for name, kind in FRAME.items():
        feature = info["features"][name]
        sized = pa.types.is_fixed_size_list(kind)
        assert feature["shape"] == [kind.list_size if sized else 1]
        assert (
            feature["dtype"]
            == {"float": "float32", "int64": "int64"}[str(kind.value_type if sized else kind)]
        )
        assert feature["names"] is None or len(feature["names"]) == feature["shape"][0]
    assert info["features"]["observation.state"]["names"][6] == "cube_0_pos_0"


def test_statistics_are_those_of_all_frames(ours, exported):
    stats = json.loads((exported / "meta/stats.json").read_text())
    assert stats.keys() == FRAME.keys()
    rows = np.concatenate([ours.split(split).concatenate("actions") for split in ("train", "val")])
    rows = rows.astype(np.float64)
    expected = {"min": rows.min(0), "max": rows.max(0), "mean": rows.mean(0), "std": rows.std(0)}
    for name, values in expected.items():
        np.testing.assert_allclose(stats["action"][name], values, rtol=1e-12)
    assert stats["action"]["count"] == [20]
    assert stats["index"]["max"] == [19]


def test_tasks_are_looked_up_by_their_text_as_pandas_keeps_it(exported):
    table = pq.read_table(exported / "meta/tasks.parquet")
    assert table.to_pylist() == [
        {"task_index": 0, "task": "play data of cube-single: any state may be the goal"}
    ]
    assert json.loads(table.schema.metadata[b"pandas"])["index_columns"] == ["task"]
