"""The page's file, read with an HTML parser."""

import os
import re
from html.parser import HTMLParser

import pytest

from pigbench.errors import UserError
from pigbench.page import page


class Reader(HTMLParser):
    """The tables' cells, row by row, and every address that the page names."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.addresses: list[str] = []
        self._in_cell = False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.addresses += [value for name, value in attrs if name in ("src", "href")]
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")
            self._in_cell = True

    def handle_endtag(self, tag):
        self._in_cell = self._in_cell and tag not in ("td", "th")

    def handle_data(self, data):
        if self._in_cell:
            self.rows[-1][-1] += data


def read(path) -> Reader:
    return Reader(path.read_text())


def test_the_page_holds_the_numbers_of_the_tables_and_needs_no_other_file(runs, tmp_path):
    file = page.write(runs, tmp_path / "out")
    assert file == tmp_path / "out/index.html"
    assert file.stat().st_size < 2_000_000
    told = read(file)
    assert ["method", "cube-double", "cube-single"] in told.rows
    assert ["gcivl", "–", "75.0 ± 35.450.0 to 100.0"] in told.rows
    assert ["hjb-gcivl", "25.0", "50.0"] in told.rows
    assert ["task2", "75.0 ± 35.450.0 to 100.0", "0.0"] in told.rows
    assert [str(runs[0]), "done", "200", "200", "50.0"] in told.rows
    assert all(re.match(r"#|data:,$", address) for address in told.addresses)


def test_a_suite_under_way_is_told_as_it_is(suite, tmp_path):
    text = page.write([suite], tmp_path / "out").read_text()
    assert "3 of 4 runs are unfinished" in text
    rows = Reader(text).rows
    assert ["gcivl", "100.0"] in rows
    assert ["cube-single/hjb-gcivl/0", "cut off", "0", "200", "100.0"] in rows
    assert ["cube-single/hjb-gcivl/1", "waiting", "0", "200", "–"] in rows
    assert "hjb-gcivl, seed 0, unfinished" in text


def test_a_suite_of_which_nothing_is_done_has_a_page(suite, tmp_path):
    for name in ("gcivl", "hjb-gcivl"):
        (suite / f"cube-single/{name}/0/config.json").unlink()
        (suite / f"cube-single/{name}/0/episodes.csv").unlink()
    rows = read(page.write([suite], tmp_path / "out")).rows
    assert ["cube-single/gcivl/0", "cut off", "0", "200", "–"] in rows


def test_films_lie_beside_the_page(runs, tmp_path):
    film = runs[0] / "films/000000200/task1-success.mp4"
    film.parent.mkdir(parents=True)
    film.write_bytes(b"film")
    told = read(page.write(runs, tmp_path / "out"))
    (name,) = (address.partition("#")[0] for address in told.addresses if ".mp4" in address)
    assert (tmp_path / "out" / name).read_bytes() == b"film"
    film.unlink()
    page.write(runs, tmp_path / "out")
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["index.html"]


def test_names_are_text_and_no_markup(tmp_path, make_run):
    agent = {"note": "</script><script>alert(1)</script>"}
    run = make_run(tmp_path / "<b>run", {200: [[1]]}, environment="<i>", agent=agent)
    text = page.write([run.path], tmp_path / "out").read_text()
    assert "alert(1)" in text
    for markup in ("<b>run", "<i>", "<script>alert"):
        assert markup not in text


def test_names_that_are_no_text_are_escaped(tmp_path, make_run):
    run = make_run(tmp_path / os.fsdecode(b"run\xff"), {200: [[1]]})
    assert r"run\udcff" in page.write([run.path], tmp_path / "out").read_text()


def test_only_a_page_is_replaced(runs, tmp_path):
    kept = {path: path.read_bytes() for path in runs[0].iterdir() if path.is_file()}
    with pytest.raises(UserError, match="not an empty folder and holds no report"):
        page.write(runs, runs[0])
    assert kept == {path: path.read_bytes() for path in runs[0].iterdir() if path.is_file()}
    with pytest.raises(UserError, match="no runs are given"):
        page.write([], tmp_path / "out")
    with pytest.raises(UserError, match="have the same seed"):
        page.write([runs[0], runs[0]], tmp_path / "out")
    assert not (tmp_path / "out").exists()
