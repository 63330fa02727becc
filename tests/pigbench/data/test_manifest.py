import dataclasses
import json
import re

import pytest

from pigbench.data import manifest
from pigbench.data.manifest import FileRecord, Manifest, ShardRecord
from pigbench.errors import UserError
from pigbench.support import files


def record(name):
    return ShardRecord(name, name[:-6], 2, 0, 8, {"actions.npy": FileRecord("ab", 12)})


def test_the_plan_cuts_every_split_into_shards(spec):
    assert [tuple(part) for part in spec.plan()] == [
        ("train-00000", "train", 0, 2),
        ("train-00001", "train", 1, 2),
        ("train-00002", "train", 2, 1),
        ("val-00000", "val", 3, 1),
    ]


def test_the_plan_does_not_depend_on_the_order_of_the_splits(spec):
    turned = dataclasses.replace(spec, episodes={"val": 1, "train": 5})
    assert turned.plan() == spec.plan()


def test_shards_keep_the_order_of_the_plan(spec):
    names = ["val-00000", "train-00001", "train-00000"]
    content = Manifest(spec, ()).with_shards(map(record, names))
    assert [shard.name for shard in content.shards] == ["train-00000", "train-00001", "val-00000"]
    assert [shard.name for shard in content.missing()] == ["train-00002"]


def test_round_trip(tmp_path, spec):
    content = Manifest(spec, (record("train-00000"),))
    manifest.write(tmp_path, content)
    assert manifest.read(tmp_path) == content


def test_the_format_on_the_disk(tmp_path, spec):
    manifest.write(tmp_path, Manifest(spec, (record("train-00000"),)))
    content = json.loads((tmp_path / "manifest.json").read_text())
    assert content["format"] == 1
    assert content["spec"]["layout"] == [["joint_pos", 6], ["cube_0_pos", 3]]
    assert content["spec"]["episodes"] == {"train": 5, "val": 1}
    assert content["shards"][0]["files"] == {"actions.npy": {"sha256": "ab", "bytes": 12}}


def test_the_origin_is_recorded_if_there_is_one(tmp_path, spec):
    assert "origin" not in spec.as_dict()  # so that digests of generated data stay
    assert "origin" not in manifest.describe(Manifest(spec, ()))
    made = dataclasses.replace(spec, origin={"F.npz": "SHA-256 ab"})
    assert manifest.spec_of(made.as_json()) == made
    manifest.write(tmp_path, Manifest(made, ()))
    assert manifest.read(tmp_path).spec == made
    assert re.search(r"^origin +F\.npz SHA-256 ab$", manifest.describe(Manifest(made, ())), re.M)


def test_what_was_imported_has_no_engine_and_no_seed(spec):
    made = manifest.describe(Manifest(spec, ()))
    assert re.search(r"^physics +profile exact, engine mujoco$", made, re.M)
    assert re.search(r"^seed +3$", made, re.M)
    imported = dataclasses.replace(spec, versions={}, origin={"F.npz": "SHA-256 ab"})
    text = manifest.describe(Manifest(imported, ()))
    assert re.search(r"^imported from +F\.npz SHA-256 ab$", text, re.M)
    assert not re.search(r"engine|^(seed|versions|origin)\b", text, re.M)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({}, "has format None; this version reads format 1"),
        ({"format": 2}, "has format 2; this version reads format 1"),
        ({"format": 1, "shards": []}, "is invalid: spec: this field is missing"),
        ({"format": 1, "spec": {"fields": [], "layout": []}, "shards": []}, "is invalid"),
        ({"format": 1, "spec": 3, "shards": []}, "is invalid: spec: 3 is no set of fields"),
    ],
)
def test_a_bad_manifest_is_named(tmp_path, content, message):
    files.write_sealed(tmp_path / "manifest.json", content)
    with pytest.raises(UserError, match=r"manifest\.json " + message) as error:
        manifest.read(tmp_path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("line", ["[]", '{"name": "train-00000"}', "{", '{"rhecksum": 1}', "3"])
def test_a_bad_journal_is_named(tmp_path, spec, line):
    manifest.write(tmp_path, Manifest(spec, ()))
    (tmp_path / manifest.JOURNAL).write_text(line + "\n")
    with pytest.raises(UserError, match=rf"{manifest.JOURNAL} is (torn|altered)"):
        manifest.read(tmp_path)


def test_no_data_set(tmp_path):
    with pytest.raises(UserError, match="is not a data set"):
        manifest.read(tmp_path)
    with pytest.raises(UserError, match="does not exist"):
        manifest.read(tmp_path / "missing")


def test_the_description_has_the_numbers(spec):
    shards = (record("train-00000"), dataclasses.replace(record("train-00001"), dropped=1))
    text = manifest.describe(Manifest(spec, shards))
    assert re.search(r"^environment +cube-single$", text, re.MULTILINE)
    assert re.search(
        r"^train +16 rows, 4 of 5 episodes, 1 dropped as diverged$", text, re.MULTILINE
    )
    assert re.search(r"^val +0 rows, 0 of 1 episodes, 0 dropped as diverged$", text, re.MULTILINE)
    assert re.search(r"^shards +2 of 4$", text, re.MULTILINE)
    assert re.search(r"^bytes +24$", text, re.MULTILINE)
    assert re.search(r"^  cube_0_pos +\[6:9\]$", text, re.MULTILINE)
