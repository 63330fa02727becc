"""Rows go to the device where they leave it room, and stay on the disk elsewhere."""

import pytest

from pigbench.data import dataset, homes
from pigbench.data.mapped import MappedArray


@pytest.mark.parametrize(
    ("room", "name"), [(20 * 14 * 4, "device"), (20 * 14 * 4 - 1, "disk")]
)  # 20 rows of 9 + 5 numbers
def test_auto_is_the_device_as_long_as_rows_fit(data, monkeypatch, room, name):
    monkeypatch.setattr(homes, "_room", lambda: room)
    split = dataset.load(data).split("train")
    home = homes.choose("auto", split)
    assert str(home) == f"rows on {name} (0.0 GB, room for 0.0)"
    rows = homes.open_rows(split, home)
    assert isinstance(rows.observations, MappedArray) == (name == "disk")
    assert rows.episode_ends.tolist() == [3, 7, 11, 15, 19]


def test_the_home_that_is_asked_for_is_taken(data):
    split = dataset.load(data).split("train")
    assert str(homes.choose("disk", split)) == "rows on disk (as asked)"
    assert 1e8 < homes._room() < 1e15
