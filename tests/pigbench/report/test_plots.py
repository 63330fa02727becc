import itertools

import numpy as np
import pytest
from PIL import Image

from pigbench.errors import UserError
from pigbench.report import plots, stats


@pytest.fixture
def results(tmp_path, make_run):
    return stats.read_results(
        make_run(
            tmp_path / f"{method}-{environment}-{seed}",
            {0: [[0, 0]], 100: [[1, seed]], 200: [[1, 1]]},
            method=method,
            environment=environment,
            seed=seed,
        )
        for method in ("gcivl", "mine")
        for environment in ("cube-single", "cube-double")
        for seed in (0, 1)
    )


def rgb(color):
    return np.array([int(color[start : start + 2], 16) for start in (1, 3, 5)])


def test_a_png_shows_every_method_in_its_colour(tmp_path, results):
    plots.plot_curves(results, tmp_path / "curves.png")
    picture = Image.open(tmp_path / "curves.png").convert("RGB")
    assert picture.width > 2 * 600
    assert picture.height > 500
    pixels = np.asarray(picture)
    for method in ("gcivl", "mine"):
        assert (pixels == rgb(plots.style(method).color)).all(axis=-1).sum() > 200


@pytest.mark.parametrize(
    ("name", "magic"), [("a.pdf", b"%PDF"), ("a.svg", b"<?xml"), ("a.PNG", b"\x89PNG")]
)
def test_the_extension_tells_the_format_and_bytes_repeat(tmp_path, results, name, magic):
    plots.plot_curves(results, tmp_path / name)
    first = (tmp_path / name).read_bytes()
    plots.plot_curves(results, tmp_path / name)
    assert first.startswith(magic)
    assert (tmp_path / name).read_bytes() == first


def test_an_unknown_format_lists_the_known(tmp_path, results):
    with pytest.raises(UserError, match=r"unknown picture format 'pgn'.*did you mean 'pn?g"):
        plots.plot_curves(results, tmp_path / "curves.pgn")


def test_methods_can_be_told_apart():
    assert len(set(plots.STYLES.values())) == len(plots.STYLES)
    for first, second in itertools.combinations(plots.PALETTE, 2):
        assert np.abs(rgb(first) - rgb(second)).sum() > 60


def test_an_unknown_method_keeps_its_style():
    assert plots.style("mine") == plots.style("mine")
    # CRC-32 of "123456789" is the published check value 0xCBF43926, which is 6 modulo 8.
    assert plots.style("123456789").color == plots.VERMILLION
