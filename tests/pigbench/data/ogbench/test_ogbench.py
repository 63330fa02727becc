"""OGBench's files: read by OGBench's own loader, and back to the same bits."""

import dataclasses
import tracemalloc
from pathlib import Path

import jax
import numpy as np
import pytest
from ogbench.utils import load_dataset, make_env_and_datasets

from pigbench import cli, envs
from pigbench.data import dataset, ogbench, shard
from pigbench.data.ogbench import reading, source
from pigbench.data.writer import Writer
from pigbench.errors import UserError
from pigbench.support.lock import only_writer

NAME = "cube-single"
WIDTHS = {"observations": 28, "actions": 5, "qpos": 21, "qvel": 20}
LENGTH = 4  # rows of an episode


def arrays_of(rows: int, seed: int) -> dict[str, np.ndarray]:
    generator = np.random.default_rng(seed)
    arrays = {
        field: generator.normal(size=(rows, width)).astype(np.float32)
        for field, width in WIDTHS.items()
    }
    return arrays | {"terminals": np.arange(rows) % LENGTH == LENGTH - 1}


@pytest.fixture
def data(tmp_path, spec) -> Path:
    """Three shards of training, of which one has lost an episode, and one of validation."""
    layout = envs.make(NAME).layout
    fields = ("observations", "actions", "terminals", "qpos", "qvel")
    writer = Writer(tmp_path / "data", dataclasses.replace(spec, layout=layout, fields=fields))
    for part in writer.missing():
        dropped = int(part.name == "train-00001")
        rows = LENGTH * (part.episodes - dropped)
        writer.write(part, arrays_of(rows, part.number), dropped=dropped)
    return tmp_path / "data"


@pytest.fixture
def exported(data, tmp_path) -> Path:
    path = tmp_path / "F.npz"
    cli.run(["data", "export", str(data), "--format", "ogbench", "--out", str(path)])
    return path


@pytest.fixture(autouse=True)
def small_shards(monkeypatch):
    monkeypatch.setattr(source, "IMPORTED_EPISODES", 50)


def import_(path: Path | list[Path], folder: Path) -> None:
    paths = [str(one) for one in (path if isinstance(path, list) else [path])]
    cli.run(["data", "import", *paths, "--environment", NAME, "--out", str(folder)])


def content(folder: Path) -> dict[tuple[str, str], np.ndarray]:
    loaded = dataset.load(folder)
    return {
        (split, field): loaded.split(split).concatenate(field)
        for split in ("train", "val")
        for field in loaded.spec.fields
    }


def test_ogbenchs_loader_reads_an_export(data, exported):
    """Episodes of 4 rows are 3 transitions, of which the third is the last."""
    ours = content(data)
    train, val = make_env_and_datasets(
        "cube-single-play-v0", dataset_path=str(exported), dataset_only=True, add_info=True
    )
    for split, theirs, episodes in (("train", train, 4), ("val", val, 1)):
        rows = np.arange(4 * episodes).reshape(episodes, 4)
        here, there = rows[:, :-1].ravel(), rows[:, 1:].ravel()
        np.testing.assert_array_equal(theirs["terminals"], np.tile([0, 0, 1], episodes))
        for field in ("observations", "actions", "qpos", "qvel"):
            np.testing.assert_array_equal(theirs[field], ours[split, field][here])
        np.testing.assert_array_equal(
            theirs["next_observations"], ours[split, "observations"][there]
        )


def test_ogbenchs_loader_reads_an_export_compact(data, exported):
    ours = content(data)
    theirs = load_dataset(exported, compact_dataset=True, add_info=True)
    np.testing.assert_array_equal(theirs["valids"], np.tile([1, 1, 1, 0], 4))
    np.testing.assert_array_equal(theirs["terminals"], np.tile([0, 0, 1, 1], 4))
    for field in ("observations", "actions", "qpos", "qvel"):
        assert theirs[field].dtype == np.float32
        np.testing.assert_array_equal(theirs[field], ours["train", field])


def test_ogbenchs_loader_makes_the_goals_of_an_export_with_cubes(tmp_path, spec):
    """In an `-oraclerep` environment of two cubes; it keeps all rows but an episode's last."""
    env = envs.make("cube-double")
    observe = jax.jit(jax.vmap(lambda qpos, qvel: env.observe(env.physics.init(qpos, qvel))))
    fields = ("observations", "actions", "terminals", "qpos", "qvel")
    layout = env.layout
    spec = dataclasses.replace(spec, environment="cube-double", layout=layout, fields=fields)
    writer = Writer(tmp_path / "data", spec)
    for part in writer.missing():
        rows = LENGTH * part.episodes
        qpos = np.random.default_rng(part.number).normal(size=(rows, 28)).astype(np.float32)
        qvel = np.zeros((rows, 26), np.float32)
        arrays = arrays_of(rows, part.number) | {"qpos": qpos, "qvel": qvel}
        writer.write(part, arrays | {"observations": np.asarray(observe(qpos, qvel))})
    path = tmp_path / "F.npz"
    cli.run(["data", "export", str(tmp_path / "data"), "--out", str(path), "--goals", "cubes"])
    _, *theirs = make_env_and_datasets("cube-double-play-oraclerep-v0", dataset_path=str(path))
    for file, split in zip((path, tmp_path / "F-val.npz"), theirs, strict=True):
        with np.load(file) as ours:
            goals, last = ours["oracle_reps"], ours["terminals"]
        assert goals.shape == (len(last), 6)
        np.testing.assert_allclose(goals[~last], split["oracle_reps"], rtol=1e-6, atol=1e-5)
    cli.run(["data", "export", str(tmp_path / "data"), "--out", str(tmp_path / "plain.npz")])
    with np.load(tmp_path / "plain.npz") as plain:
        assert set(plain) == set(fields)


def test_there_and_back_is_equal_to_the_bit(data, exported, tmp_path):
    import_(exported, tmp_path / "back")
    before, after = content(data), content(tmp_path / "back")
    assert before.keys() == after.keys()
    for key, array in before.items():
        assert array.dtype == after[key].dtype
        assert array.tobytes() == after[key].tobytes()
    assert dataset.verify(tmp_path / "back") == []
    assert dataset.load(tmp_path / "back").layout == dataset.load(data).layout


def test_an_export_has_the_same_bytes_each_time(data, exported):
    before = exported.read_bytes()
    ogbench.write(dataset.load(data), exported)
    assert exported.read_bytes() == before
    assert {path.name for path in exported.parent.iterdir()} == {"data", "F.npz", "F-val.npz"}


@pytest.fixture
def theirs() -> dict[str, dict[str, np.ndarray]]:
    """By split, 120 and 8 episodes as a generator of OGBench's may have them in memory."""
    return {
        split: {
            field: array if field == "terminals" else array.astype(np.float64)
            for field, array in arrays_of(LENGTH * episodes, episodes).items()
        }
        for split, episodes in (("F", 120), ("F-val", 8))
    }


def save(folder: Path, splits: dict[str, dict[str, np.ndarray]]) -> Path:
    for split, arrays in splits.items():
        np.savez_compressed(folder / f"{split}.npz", **arrays)  # pyright: ignore[reportArgumentType]
    return folder / "F.npz"


def test_reads_compressed_files_in_double_precision(tmp_path, theirs):
    import_(save(tmp_path, theirs), tmp_path / "data")
    loaded = dataset.load(tmp_path / "data")
    assert [record.episodes for record in loaded.manifest.shards] == [50, 50, 20, 8]
    assert loaded.spec.environment == NAME
    assert loaded.spec.is_imported
    for (split, field), array in content(tmp_path / "data").items():
        expected = theirs["F" if split == "train" else "F-val"][field]
        np.testing.assert_array_equal(array, expected.astype(shard.DTYPES[field]))


def test_an_import_cut_off_goes_on(tmp_path, theirs, monkeypatch):
    path = save(tmp_path, theirs)
    import_(path, tmp_path / "whole")
    written, write = [], Writer.write

    def killed(self, part, arrays):
        if written:
            raise KeyboardInterrupt
        written.append(part)
        write(self, part, arrays)

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(Writer, "write", killed)
        import_(path, tmp_path / "cut")
    with pytest.raises(UserError, match=r"unfinished: 3 of 4 shards .*pigbench data import"):
        dataset.load(tmp_path / "cut")
    import_(path, tmp_path / "cut")
    assert dataset.load(tmp_path / "cut").digest == dataset.load(tmp_path / "whole").digest


def test_other_files_do_not_continue_an_import(tmp_path, theirs):
    path = save(tmp_path, theirs)
    import_(path, tmp_path / "data")
    theirs["F"]["actions"][0, 0] += 1
    save(tmp_path, theirs)
    with pytest.raises(UserError, match=r"origin\.F\.npz is 'SHA-256"):
        import_(path, tmp_path / "data")


def test_positions_and_velocities_may_be_absent(tmp_path, theirs):
    for arrays in theirs.values():
        del arrays["qpos"], arrays["qvel"]
    import_(save(tmp_path, theirs), tmp_path / "data")
    loaded = dataset.load(tmp_path / "data")
    assert loaded.spec.fields == ("observations", "actions", "terminals")
    with pytest.raises(UserError, match="has no qpos, of which OGBench's loader makes such goals"):
        ogbench.write(loaded, tmp_path / "G.npz", goals="cubes")


def changed(field: str, change):
    def apply(arrays: dict[str, np.ndarray]) -> None:
        arrays[field] = change(arrays[field])

    return apply


WRONG = {
    "a field missing": (lambda arrays: arrays.pop("actions"), "has no actions"),
    "another environment": (
        changed("observations", lambda a: np.pad(a, ((0, 0), (0, 9)))),
        r"does not fit cube-single: observations has shape \(480, 37\) instead of \(480, 28\)",
    ),
    "a row short": (
        changed("actions", lambda a: a[:-1]),
        r"actions has shape \(479, 5\) instead of \(480, 5\)",
    ),
    "no rows": (
        lambda arrays: [changed(field, lambda a: a[:0])(arrays) for field in list(arrays)],
        "no whole episode",
    ),
    "no terminals": (changed("terminals", np.zeros_like), "no whole episode"),
    "a cut episode": (
        lambda arrays: [changed(field, lambda a: a[:-2])(arrays) for field in list(arrays)],
        r"ends within an episode: the last whole one ends in row 475",
    ),
    "no numbers": (changed("actions", lambda a: a.astype(str)), "actions of type <U.*, not numb"),
    "objects": (changed("actions", lambda a: a.astype(object)), "actions of type object"),
    "next observations of another row": (
        lambda arrays: arrays.update(next_observations=arrays["observations"]),
        "next_observations are not the observations of the next row",
    ),
    "NaN": (
        changed("qvel", lambda a: np.where(np.arange(480)[:, None] == 203, np.nan, a)),
        r"train-00001 of qvel holds NaN or infinity \(first in row 3\)",
    ),
}


@pytest.mark.parametrize(("change", "says"), WRONG.values(), ids=WRONG)
def test_wrong_files_are_named(tmp_path, theirs, change, says):
    change(theirs["F"])
    path = save(tmp_path, theirs)
    with pytest.raises(UserError, match=rf"F\.npz.*{says}"):
        import_(path, tmp_path / "data")


def assert_holds(folder: Path, theirs: dict[str, dict[str, np.ndarray]], *fields: str) -> None:
    found = content(folder)
    assert {field for _, field in found} == {*fields, "terminals"}
    for (split, field), array in found.items():
        expected = theirs["F" if split == "train" else "F-val"][field]
        np.testing.assert_array_equal(array, expected.astype(shard.DTYPES[field]))
    assert dataset.verify(folder) == []


def test_episodes_may_differ_in_length(tmp_path, theirs):
    ends = np.append(np.arange(1, 477, 7), 479)
    theirs["F"]["terminals"] = np.isin(np.arange(480), ends)
    import_(save(tmp_path, theirs), tmp_path / "data")
    assert_holds(tmp_path / "data", theirs, *WIDTHS)
    split = dataset.load(tmp_path / "data").split("train")
    np.testing.assert_array_equal(split.episode_ends, ends)
    assert [record.rows for record in split.records] == [2 + 49 * 7, 480 - 2 - 49 * 7]


def test_arrays_may_be_stored_column_by_column(tmp_path, theirs):
    for arrays in theirs.values():
        arrays.update({field: np.asfortranarray(array) for field, array in arrays.items()})
    import_(save(tmp_path, theirs), tmp_path / "data")
    assert_holds(tmp_path / "data", theirs, *WIDTHS)


@pytest.mark.parametrize("compact", [True, False])
def test_what_ogbenchs_loader_returns_is_read(exported, data, tmp_path, compact):
    loaded = {
        name: load_dataset(exported.with_stem(name), compact_dataset=compact, add_info=True)
        for name in ("F", "F-val")
    }
    (tmp_path / "loaded").mkdir()
    import_(save(tmp_path / "loaded", loaded), tmp_path / "back")
    before, after = content(data), content(tmp_path / "back")
    assert {field for _, field in after} == {
        *("observations", "actions", "terminals"),
        *(("qpos", "qvel") if compact else ()),
    }
    for (split, field), array in after.items():
        expected = before[split, field]
        if field == "actions" and not compact:
            expected = np.where(before[split, "terminals"][:, None], 0, expected)
        np.testing.assert_array_equal(array, expected)


def test_a_folder_of_files_is_one_data_set(tmp_path, theirs, monkeypatch):
    """A file is a shard, if it has no more episodes than one holds."""
    monkeypatch.setattr(source, "IMPORTED_EPISODES", 1000)
    (tmp_path / "files").mkdir()
    expected = {"F": {}, "F-val": {}}
    for number, episodes in enumerate((30, 7, 12)):
        parts = {
            "F": arrays_of(LENGTH * episodes, number),
            "F-val": arrays_of(LENGTH * 2, 9 + number),
        }
        for name, arrays in parts.items():
            for field, array in arrays.items():
                expected[name].setdefault(field, []).append(array)
        save(tmp_path / "files", {f"a{number}{name[1:]}": a for name, a in parts.items()})
    whole = {
        name: {field: np.concatenate(own) for field, own in arrays.items()}
        for name, arrays in expected.items()
    }
    import_(tmp_path / "files", tmp_path / "data")
    assert_holds(tmp_path / "data", whole, *WIDTHS)
    loaded = dataset.load(tmp_path / "data")
    assert [record.episodes for record in loaded.manifest.shards] == [30, 7, 12, 2, 2, 2]
    named = [tmp_path / "files" / f"a{number}.npz" for number in range(3)]
    import_(named, tmp_path / "named")
    assert dataset.load(tmp_path / "named").digest == loaded.digest
    with pytest.raises(UserError, match=r"two files are named a1\.npz"):
        import_([*named, named[1]], tmp_path / "twice")
    with pytest.raises(UserError, match=r"holds no \.npz file of training"):
        import_(tmp_path / "data", tmp_path / "none")


@pytest.mark.parametrize("field", ["observations", "actions", "terminals", "qpos", "qvel"])
@pytest.mark.parametrize("shape", [(40_000, 1), (40_000, 1, 1), (40_000,), (), (0,)])
def test_shapes_are_looked_at_before_any_content(tmp_path, field, shape):
    """A flag a row in a column of its own would be N x N when held against N flags."""
    rows = 40_000
    arrays = {name: np.zeros((rows, width), np.float32) for name, width in WIDTHS.items()}
    arrays["terminals"] = np.zeros(rows, bool)
    if arrays[field].shape == shape:
        return
    arrays[field] = np.zeros(shape, arrays[field].dtype)
    for ending in ("", "-val"):
        np.savez_compressed(tmp_path / f"F{ending}.npz", **arrays)
    tracemalloc.start()
    with pytest.raises(UserError, match=r"F\.npz does not fit cube-single: .* has shape"):
        import_(tmp_path / "F.npz", tmp_path / "data")
    assert tracemalloc.get_traced_memory()[1] < 50e6
    tracemalloc.stop()
    assert not (tmp_path / "data").exists()


def test_imports_into_one_folder_keep_out_of_each_others_way(exported, tmp_path):
    with (
        only_writer(tmp_path / "back"),
        pytest.raises(UserError, match="is being written by another process"),
    ):
        import_(exported, tmp_path / "back")
    assert not list((tmp_path / "back").iterdir())
    import_(exported, tmp_path / "back")


@pytest.mark.parametrize("name", ["F.npz", "F-val.npz"])
def test_missing_and_torn_files_are_named(tmp_path, theirs, name):
    path = save(tmp_path, theirs)
    whole = (tmp_path / name).read_bytes()
    middle = len(whole) // 2
    flipped = whole[:middle] + bytes([whole[middle] ^ 255]) + whole[middle + 1 :]
    for torn in (b"", whole[:middle], flipped, b"PK" + whole[2:500]):
        (tmp_path / name).write_bytes(torn)
        with pytest.raises(UserError, match=rf"{name} is torn"):
            import_(path, tmp_path / f"data{len(torn)}")
    (tmp_path / name).unlink()
    with pytest.raises(UserError, match=rf"{name} does not exist"):
        import_(path, tmp_path / "data")


def test_an_export_in_files_of_a_size_comes_back(data, tmp_path):
    (tmp_path / "files").mkdir()
    options = ["--out", str(tmp_path / "files/F.npz"), "--rows-per-file", "12"]
    cli.run(["data", "export", str(data), *options])
    assert sorted(path.name for path in (tmp_path / "files").iterdir()) == [
        *("F-000-val.npz", "F-000.npz", "F-001.npz")
    ]
    with np.load(tmp_path / "files/F-001.npz") as last:
        assert len(last["actions"]) == 4  # of shards with 8, 4 and 4 rows
    import_(tmp_path / "files", tmp_path / "back")
    for key, array in content(data).items():
        np.testing.assert_array_equal(array, content(tmp_path / "back")[key])


def test_validation_files_count_beside_training_files_and_alone(tmp_path):
    for name in ("F-000.npz", "F-000-val.npz", "F-001-val.npz", "G.npz", "G-val.npz"):
        (tmp_path / name).touch()
    found = reading._files([tmp_path])
    assert {split: [file.name for file in own] for split, own in found.items()} == {
        "train": ["F-000.npz", "G.npz"],
        "val": ["F-000-val.npz", "G-val.npz", "F-001-val.npz"],
    }
    named = reading._files([tmp_path / "F-000.npz", tmp_path / "F-001-val.npz"])
    assert [file.name for file in named["val"]] == ["F-000-val.npz", "F-001-val.npz"]


def test_exports_that_cannot_be(data, tmp_path):
    loaded = dataset.load(data)
    with pytest.raises(UserError, match=r"F\.h5 does not end in \.npz"):
        ogbench.write(loaded, tmp_path / "F.h5")
    with pytest.raises(UserError, match="unknown goals 'cube': did you mean 'cubes'"):
        ogbench.write(loaded, tmp_path / "F.npz", goals="cube")
    with pytest.raises(UserError, match="unknown format 'ogbnch': did you mean 'ogbench'"):
        cli.run(["data", "export", str(data), "--out", "F.npz", "--format", "ogbnch"])
