import errno
import hashlib
import os
from pathlib import Path

import pytest

from pigbench.errors import UserError
from pigbench.support import files


class Killed(BaseException):
    pass


def test_json_survives_a_round_trip_and_has_the_same_bytes_each_time(tmp_path):
    value = {"b": [1, 2.5, None], "a": {"ä": True}}
    files.write_json(tmp_path / "x.json", value)
    first = (tmp_path / "x.json").read_bytes()
    files.write_json(tmp_path / "x.json", value)
    assert files.read_json(tmp_path / "x.json") == value
    assert (tmp_path / "x.json").read_bytes() == first
    assert os.listdir(tmp_path) == ["x.json"]


@pytest.mark.parametrize("function", ["replace", "fsync"])
def test_an_interrupted_write_keeps_the_old_content(tmp_path, monkeypatch, function):
    path = tmp_path / "x.txt"
    files.write_text(path, "old")

    def kill(*_):
        raise Killed

    monkeypatch.setattr(os, function, kill)
    with pytest.raises(Killed):
        files.write_text(path, "new")
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["x.txt"]


def test_a_folder_is_replaced_as_a_whole(tmp_path):
    path = tmp_path / "shard"
    path.mkdir()
    (path / "old").touch()
    files.temporary_path(path).mkdir()
    (files.temporary_path(path) / "leftover").touch()
    with files.replacing_folder(path) as new:
        (new / "a").write_text("1")
        assert os.listdir(path) == ["old"]
    assert os.listdir(path) == ["a"]
    assert os.listdir(tmp_path) == ["shard"]


def test_a_folder_that_fails_leaves_no_trace(tmp_path):
    with pytest.raises(Killed), files.replacing_folder(tmp_path / "shard") as new:
        (new / "a").write_text("1")
        raise Killed
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EDQUOT])
def test_a_full_disk_is_explained(tmp_path, monkeypatch, number):
    def full(*_):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(UserError, match=r"no space left on device while writing .*x\.txt; free"):
        files.write_text(tmp_path / "x.txt", "text")


def test_what_is_no_file_is_not_replaced(tmp_path):
    (tmp_path / "x.txt").mkdir()
    for path in (tmp_path / "x.txt", Path("/dev/full")):
        with pytest.raises(UserError, match=rf"{path} is not a file"):
            files.write_text(path, "text")
    assert Path("/dev/full").is_char_device()


def test_a_missing_folder_is_made(tmp_path):
    files.write_text(tmp_path / "missing" / "x.txt", "text")
    assert (tmp_path / "missing" / "x.txt").read_text() == "text"


def test_a_folder_can_be_asked_about_without_a_trace(tmp_path):
    files.require_folder(tmp_path / "a" / "b")
    files.require_file(tmp_path / "a" / "x.txt")
    assert not list(tmp_path.iterdir())
    (tmp_path / "a").touch()
    with pytest.raises(UserError, match=r"/a is not a folder"):
        files.require_folder(tmp_path / "a" / "b")


def test_a_file_has_one_writer(tmp_path):
    path = tmp_path / "x.txt"
    with files.replacing_file(path) as file:
        file.write(b"first")
        with pytest.raises(UserError, match="is being written by another process"):
            files.write_text(path, "second")
    assert path.read_text() == "first"
    assert os.listdir(tmp_path) == ["x.txt"]


@pytest.mark.parametrize("content", [b"", b'{"a": 1', b"\xff\xfe"])
def test_torn_json_is_named(tmp_path, content):
    path = tmp_path / "x.json"
    path.write_bytes(content)
    with pytest.raises(UserError, match=r"x\.json is torn: ") as error:
        files.read_json(path)
    assert "\n" not in str(error.value)


def test_what_is_sealed_is_read_as_it_was_written_or_not_at_all(tmp_path):
    path = tmp_path / "x.json"
    files.write_sealed(path, {"a": 1, "b": [2.5, "c"]})
    assert files.read_sealed(path) == {"a": 1, "b": [2.5, "c"]}
    path.write_text(path.read_text().replace("2.5", "2.6"))
    with pytest.raises(UserError, match=r"x\.json is altered: its checksum does not match"):
        files.read_sealed(path)
    for content in ("{}", "[]", "3"):
        path.write_text(content)
        with pytest.raises(UserError, match=r"x\.json is altered: it has no checksum"):
            files.read_sealed(path)


def test_missing_json_is_named(tmp_path):
    with pytest.raises(UserError, match=r"x\.json does not exist"):
        files.read_json(tmp_path / "x.json")


def test_sha256_of_the_standard_vector(tmp_path):
    (tmp_path / "abc").write_bytes(b"abc")
    # FIPS 180-2, appendix B.1.
    expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    assert files.sha256(tmp_path / "abc") == expected
    large = bytes(range(256)) * 5000
    (tmp_path / "large").write_bytes(large)
    assert files.sha256(tmp_path / "large") == hashlib.sha256(large).hexdigest()
