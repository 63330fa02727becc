"""The page in headless Chromium: it draws, sorts and hides, and asks nobody for anything."""

import io
from collections.abc import Iterator
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from pigbench.page import page
from pigbench.support import pictures

from . import browser
from .browser import Page

PROGRAM = browser.find()

pytestmark = pytest.mark.skipif(PROGRAM is None, reason="Chromium is not installed")


@pytest.fixture(scope="module")
def tab(tmp_path_factory) -> Iterator[Page]:
    assert PROGRAM is not None
    with browser.opened(PROGRAM, tmp_path_factory.mktemp("profile")) as tab:
        yield tab


@pytest.fixture
def file(runs, tmp_path) -> Path:
    frames = [np.full((24, 32, 3), 10 * number, np.uint8) for number in range(20)]
    pictures.write_mp4(runs[0] / "films/000000200/task1-success.mp4", frames, rate=10)
    return page.write(runs, tmp_path / "out")


def brightness(tab: Page) -> float:
    """Of what is seen, from 0 to 1."""
    return float(matplotlib.image.imread(io.BytesIO(tab.screenshot()))[..., :3].mean())


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("width", [1280, 390])
def test_it_draws_without_a_complaint_or_a_request(tab, file, width, dark):
    tab.open(file, width=width, dark=dark)
    assert tab.evaluate("Bokeh.documents.length") == 2 * 3  # figures of two environments
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    assert (brightness(tab) < 0.4) == dark
    colours = tab.evaluate(
        "Bokeh.documents[0].roots()[0].xaxis?.[0]?.major_label_text_color"
        " ?? [...Bokeh.documents[0].roots()[0].references()]"
        ".find((model) => model.type === 'LinearAxis').major_label_text_color"
    )
    assert colours == ("#b9bcc4" if dark else "#4a4d55")
    tab.wait("document.querySelector('video').readyState >= 1")
    assert tab.evaluate("document.querySelector('video').duration") == pytest.approx(2, abs=0.1)
    assert tab.complaints == []
    assert {url.split(":")[0] for url in tab.requests} <= {"file", "data"}


def test_a_click_sorts_a_table_and_another_turns_it_round(tab, file):
    tab.open(file, width=1280)
    column = "document.querySelector('#success thead th:nth-child(3)')"
    rows = (
        "[...document.querySelectorAll('#success tbody tr')].map((row) => row.cells[2].innerText)"
    )
    for direction, first in (("descending", "75.0"), ("ascending", "50.0")):
        tab.evaluate(f"{column}.querySelector('button').click()")
        assert tab.evaluate(f"{column}.getAttribute('aria-sort')") == direction
        assert tab.evaluate(rows)[0].startswith(first)
    tab.evaluate("document.querySelector('#success thead th:nth-child(2) button').click()")
    assert tab.evaluate(rows)[-1].startswith("75.0")  # its second column is missing: last


def test_a_click_hides_a_method_in_all_figures(tab, file):
    tab.open(file, width=1280)
    visible = (
        "Bokeh.documents.flatMap((one) => [...one.roots()[0].references()])"
        ".filter((model) => model.name === 'gcivl').map((model) => model.visible)"
    )
    button = "document.querySelector('.legend [data-method=gcivl]')"
    shown = tab.evaluate(visible)
    assert len(shown) > 3
    assert all(shown)
    tab.evaluate(f"{button}.click()")
    assert not any(tab.evaluate(visible))
    tab.evaluate(f"{button}.click()")
    assert all(tab.evaluate(visible))


def test_the_theme_can_be_chosen(tab, file):
    tab.open(file, width=1280, dark=True)
    assert brightness(tab) < 0.4
    tab.evaluate("document.querySelector('.theme').click()")
    assert brightness(tab) > 0.8
