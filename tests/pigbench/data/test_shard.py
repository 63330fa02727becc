import numpy as np
import pytest

from pigbench.data import shard


def write(tmp_path, spec, arrays, dropped=0):
    return shard.write(tmp_path, spec, spec.plan()[0], arrays, dropped=dropped)


def test_the_files_are_plain_npy(tmp_path, spec, arrays):
    fields = arrays(spec, spec.plan()[0])
    record = write(tmp_path, spec, fields)
    assert (record.split, record.episodes, record.dropped, record.rows) == ("train", 2, 0, 8)
    for field, array in fields.items():
        path = tmp_path / "train-00000" / f"{field}.npy"
        stored = np.load(path)
        assert stored.dtype == array.dtype
        np.testing.assert_array_equal(stored, array)
        assert record.files[path.name].bytes == path.stat().st_size


def test_the_bytes_are_those_of_numpy_whatever_the_memory_order(tmp_path, spec, arrays):
    fields = arrays(spec, spec.plan()[0])
    fields["actions"] = np.asfortranarray(fields["actions"])
    write(tmp_path, spec, fields)
    np.save(tmp_path / "expected.npy", np.ascontiguousarray(fields["actions"]))
    written = (tmp_path / "train-00000" / "actions.npy").read_bytes()
    assert written == (tmp_path / "expected.npy").read_bytes()


def test_dropped_episodes_have_no_rows(tmp_path, spec, arrays):
    part = spec.plan()[0]
    record = write(tmp_path, spec, arrays(spec, part, dropped=2), dropped=2)
    assert (record.episodes, record.dropped, record.rows) == (0, 2, 0)
    assert shard.read(tmp_path, record, "observations").shape == (0, 9)


@pytest.mark.parametrize(
    ("field", "change", "message"),
    [
        ("observations", lambda a: a.astype(np.float64), "has type float64 instead of float32"),
        ("observations", lambda a: a[:, 1:], r"has shape \(8, 8\) instead of \(8, 9\)"),
        ("actions", lambda a: a[1:], r"has shape \(7, 5\) instead of \(8, 5\)"),
        ("actions", lambda a: np.where(a == a[5, 2], np.nan, a), r"NaN or infinity .* row 5\)"),
        ("qpos", lambda a: np.where(a == a[1, 0], np.inf, a), r"NaN or infinity .* row 1\)"),
        ("terminals", np.zeros_like, r"end an episode every 4 rows .* row 3\)"),
        ("terminals", lambda a: a | (np.arange(8) == 1), r"end an episode .* row 1\)"),
    ],
)
def test_arrays_that_are_not_the_specified_are_refused(
    tmp_path, spec, arrays, field, change, message
):
    fields = arrays(spec, spec.plan()[0])
    fields[field] = change(fields[field])
    with pytest.raises(ValueError, match=f"{field} of train-00000 .*{message}"):
        write(tmp_path, spec, fields)
    assert list(tmp_path.iterdir()) == []


def test_a_missing_field_is_refused(tmp_path, spec, arrays):
    fields = arrays(spec, spec.plan()[0])
    del fields["qpos"]
    with pytest.raises(ValueError, match="train-00000 has fields"):
        write(tmp_path, spec, fields)
