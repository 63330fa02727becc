"""Pictures and films, read back by Pillow and PyAV."""

import sys

import numpy as np
import pytest
from PIL import Image

from pigbench.errors import UserError
from pigbench.support import pictures


def gradient(shade: int) -> np.ndarray:
    picture = np.zeros((48, 64, 3), np.uint8)
    picture[..., 0] = np.linspace(0, 255, 64)
    picture[:24, :, 2] = shade
    return picture


def test_a_png_is_the_array(tmp_path):
    pictures.write_png(tmp_path / "x.png", gradient(200)[::-1])
    stored = np.asarray(Image.open(tmp_path / "x.png").convert("RGB"))
    np.testing.assert_array_equal(stored, gradient(200)[::-1])


def test_a_film_shows_the_arrays_at_their_rate(tmp_path):
    av = pytest.importorskip("av")
    shades = [0, 80, 160, 240]
    pictures.write_mp4(tmp_path / "x.mp4", map(gradient, shades), rate=20)
    with av.open(tmp_path / "x.mp4") as film:
        assert film.streams.video[0].average_rate == 20
        frames = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
    assert len(frames) == len(shades)
    for frame, shade in zip(frames, shades, strict=True):
        # Films are lossy: compared on average over areas of one colour.
        assert np.abs(frame.astype(int) - gradient(shade)).mean() < 8
    pictures.write_mp4(tmp_path / "y.mp4", map(gradient, shades), rate=20)
    assert (tmp_path / "x.mp4").read_bytes() == (tmp_path / "y.mp4").read_bytes()


def test_a_film_cut_off_leaves_nothing(tmp_path):
    pytest.importorskip("av")

    def broken():
        yield gradient(0)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        pictures.write_mp4(tmp_path / "x.mp4", broken(), rate=20)
    assert not list(tmp_path.iterdir())


def test_without_pyav(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(UserError, match=r"pip install 'pigbench\[render\]'"):
        pictures.write_mp4(tmp_path / "x.mp4", [gradient(0)], rate=20)


def test_paths(tmp_path):
    pictures.check_path(tmp_path / "x.PNG", ".png")
    with pytest.raises(UserError, match=r"x\.jpg does not end in \.png"):
        pictures.check_path(tmp_path / "x.jpg", ".png")
    (tmp_path / "file").touch()
    with pytest.raises(UserError, match="file is not a folder"):
        pictures.check_path(tmp_path / "file" / "x.png", ".png")
