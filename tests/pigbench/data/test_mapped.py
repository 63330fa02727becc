"""Arrays that stay on the disk give the rows that arrays in memory give."""

import numpy as np
import pytest

from pigbench.data.mapped import MappedArray
from pigbench.errors import UserError

LENGTHS = (3, 1, 0, 5)


@pytest.fixture
def files(tmp_path):
    draws = np.random.default_rng(0)
    paths = [tmp_path / f"{number}.npy" for number in range(len(LENGTHS))]
    for path, length in zip(paths, LENGTHS, strict=True):
        np.save(path, draws.standard_normal((length, 4), np.float32))
    return paths


def mapped(files) -> MappedArray:
    return MappedArray([np.load(path, mmap_mode="r+") for path in files], files)


@pytest.mark.parametrize("shape", [(40,), (2, 3, 7), (0,)])
def test_rows_are_those_of_the_arrays_put_together(files, shape):
    array = mapped(files)
    whole = np.concatenate([np.load(path) for path in files])
    assert (array.shape, array.dtype) == ((9, 4), np.float32)
    rows = np.random.default_rng(1).integers(0, 9, shape).astype(np.int32)
    np.testing.assert_array_equal(array[rows], whole[rows])
    np.testing.assert_array_equal(array[1::3], whole[1::3])


def test_what_is_not_finite_is_named_when_it_is_met(files):
    arrays = [np.load(path) for path in files]
    arrays[3][2, 1] = np.inf
    array = MappedArray(arrays, files)
    array[np.array([0, 5, 7, 8])]
    with pytest.raises(UserError, match=r"3\.npy holds NaN or infinity \(in row 2\)"):
        array[np.array([0, 6])]
