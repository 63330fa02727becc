import dataclasses
import os
import resource

import numpy as np
import pytest

from pigbench import cli
from pigbench.data import dataset, manifest
from pigbench.data.writer import Writer
from pigbench.errors import UserError
from pigbench.layout import Layout
from pigbench.support import files


def flip_byte(path, position):
    content = bytearray(path.read_bytes())
    content[position] ^= 1
    path.write_bytes(content)


def test_what_was_written_is_read(data, spec, arrays):
    train = dataset.load(data).split("train")
    parts = [arrays(spec, part) for part in spec.plan() if part.split == "train"]
    assert train.rows == 20
    for field in spec.fields:
        expected = np.concatenate([part[field] for part in parts])
        np.testing.assert_array_equal(train.concatenate(field), expected)
        shards = train.shards(field)
        assert all(isinstance(shard, np.memmap) for shard in shards)
        np.testing.assert_array_equal(shards[1], parts[1][field])


@pytest.mark.parametrize("form", ["ogbench", "minari", "lerobot"])
def test_no_export_has_many_shards_open_at_once(tmp_path, spec, arrays, monkeypatch, form):
    if form != "ogbench":
        pytest.importorskip("pyarrow.parquet")
    writer = Writer(
        tmp_path / "data",
        dataclasses.replace(spec, episodes={"train": 30, "val": 1}, episodes_per_shard=1),
    )
    for part in writer.missing():
        writer.write(part, arrays(spec, part))
    export = cli.parse(
        ["data", "export", str(writer.folder), "--format", form, "--out", str(tmp_path / "x.npz")]
    )
    monkeypatch.setattr(files, "allow_many_open", pytest.fail)
    before = resource.getrlimit(resource.RLIMIT_NOFILE)
    free = sorted(set(range(1000)) - set(map(int, os.listdir("/proc/self/fd"))))
    few = free[20]
    resource.setrlimit(resource.RLIMIT_NOFILE, (few, before[1]))
    try:
        export.run()
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, before)


@pytest.mark.parametrize("split, count", [("train", 4), ("val", 1)])
def test_episodes_are_counted_over_shards(tmp_path, spec, arrays, split, count):
    writer = Writer(tmp_path, spec)
    for part in writer.missing():  # the second shard is one episode short
        dropped = int(part.name == "train-00001")
        writer.write(part, arrays(spec, part, dropped=dropped), dropped=dropped)
    data = dataset.load(tmp_path)
    whole = data.split(split).concatenate("qpos").reshape(count, 4, -1)
    assert len(np.unique(whole)) > count
    for number, expected in enumerate(whole):
        np.testing.assert_array_equal(data.episode(split, number, "qpos"), expected)
    for number in (-1, count):
        with pytest.raises(UserError, match=rf"has {split} episodes 0 to {count - 1}"):
            data.episode(split, number, "qpos")


def test_layout_and_digest(data):
    loaded = dataset.load(data)
    assert loaded.layout == Layout.of({"joint_pos": 6, "cube_0_pos": 3})
    assert loaded.digest == files.sha256(data / "manifest.json")


def test_unknown_names_offer_the_nearest(data, spec):
    loaded = dataset.load(data)
    with pytest.raises(UserError, match="unknown split 'trian': did you mean 'train'"):
        loaded.split("trian")
    with pytest.raises(UserError, match="unknown field 'pos': did you mean 'qpos'"):
        loaded.split("train").shards("pos")


def test_a_split_without_rows_is_an_error(tmp_path, spec, arrays):
    writer = Writer(tmp_path / "data", dataclasses.replace(spec, episodes={"train": 1, "val": 0}))
    (part,) = writer.missing()
    writer.write(part, arrays(spec, part, dropped=1), dropped=1)
    loaded = dataset.load(tmp_path / "data")
    for split in ("train", "val"):
        with pytest.raises(UserError, match=f"holds no {split} episodes"):
            loaded.split(split)


def test_an_unfinished_data_set_says_how_to_finish(tmp_path, spec, arrays):
    writer = Writer(tmp_path / "data", spec)
    writer.write(writer.missing()[0], arrays(spec, writer.missing()[0]))
    with pytest.raises(UserError, match=r"unfinished: 3 of 4 shards .* `pigbench generate` again"):
        dataset.load(tmp_path / "data")
    assert dataset.verify(tmp_path / "data") == [
        f"{tmp_path / 'data' / name} is missing"
        for name in ("train-00001", "train-00002", "val-00000")
    ]


def test_missing_and_truncated_files_are_named_on_loading(data):
    path = data / "train-00001" / "actions.npy"
    os.truncate(path, 130)
    with pytest.raises(UserError, match=r"train-00001/actions\.npy is torn: 130 bytes instead"):
        dataset.load(data)
    path.unlink()
    with pytest.raises(UserError, match=r"train-00001/actions\.npy is missing"):
        dataset.load(data)


def test_an_unreadable_array_is_named(data):
    flip_byte(data / "train-00000" / "actions.npy", 0)
    with pytest.raises(UserError, match=r"train-00000/actions\.npy is torn"):
        dataset.load(data).split("train").concatenate("actions")


def test_verify_finds_every_bad_file(data):
    assert dataset.verify(data) == []
    flip_byte(data / "train-00000" / "observations.npy", 200)
    flip_byte(data / "train-00001" / "terminals.npy", 3)
    os.truncate(data / "train-00002" / "qpos.npy", 0)
    (data / "val-00000" / "actions.npy").unlink()
    altered = "is altered: its SHA-256 is not the manifest's"
    assert dataset.verify(data) == [
        f"{data / 'train-00000' / 'observations.npy'} {altered}",
        f"{data / 'train-00001' / 'terminals.npy'} {altered}",
        f"{data / 'train-00002' / 'qpos.npy'} is torn: 0 bytes instead of 240",
        f"{data / 'val-00000' / 'actions.npy'} is missing",
    ]


def test_nan_is_found_by_verify_and_on_reading(data):
    path = data / "train-00001" / "observations.npy"
    array = np.load(path)
    array[2, 3] = np.nan
    np.save(path, array)
    # A manifest that vouches for the file, as one made by another tool would.
    content = files.read_sealed(data / "manifest.json")
    content["shards"][1]["files"][path.name]["sha256"] = files.sha256(path)
    files.write_sealed(data / "manifest.json", content)
    message = f"{path} holds NaN or infinity (first in row 2)"
    assert dataset.verify(data) == [message]
    with pytest.raises(UserError) as error:
        dataset.load(data).split("train").concatenate("observations")
    assert str(error.value) == message


@pytest.mark.parametrize(
    ("terms", "message"),
    [
        (
            {"joint_pos": 6, "cube_0_yaw": 2},
            "term 1 of an observation is 'cube_0_pos' of size 3 in the data and 'cube_0_yaw' of si",
        ),
        ({"joint_pos": 6}, "'cube_0_pos' of size 3 in the data and nothing in the env"),
    ],
)
def test_a_layout_that_does_not_fit_is_explained(data, terms, message):
    loaded = dataset.load(data)
    dataset.check_layout(loaded, loaded.layout)
    with pytest.raises(UserError, match=message):
        dataset.check_layout(loaded, Layout.of(terms))


def test_loading_needs_a_readable_manifest(data):
    os.truncate(data / manifest.FILE_NAME, 50)
    for read in (dataset.load, dataset.verify):
        with pytest.raises(UserError, match=r"manifest\.json is torn"):
            read(data)
