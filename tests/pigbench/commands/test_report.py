"""`pigbench report`, and a suite's page."""

import re
import subprocess
import sys

import pytest

from pigbench import cli
from pigbench.commands import suite as suite_command
from pigbench.errors import UserError
from pigbench.report.scoring import CHECKPOINTS

REFUSAL = r"this needs the package bokeh: pip install 'pigbench\[report\]'"


@pytest.fixture
def run(make_run, tmp_path):
    return make_run(tmp_path / "run", {0: [[0]], 100: [[1, 1]], 200: [[1, 0]]}).path


@pytest.fixture
def no_bokeh(monkeypatch):
    """As where the extra is not installed."""
    for name in [name for name in sys.modules if name.partition(".")[0] == "bokeh"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "bokeh", None)


def test_the_page_follows_the_choice_of_checkpoint(run, tmp_path, capsys):
    for checkpoint, rate in {"last": "50.0", "best": "100.0"}.items():
        out = tmp_path / checkpoint
        cli.run(["report", str(run), "--out", str(out), "--checkpoint", checkpoint])
        assert capsys.readouterr().out == f"{out}/index.html is written\n"
        page = (out / "index.html").read_text()
        headline = page[page.index('<section id="success">') :].partition("</section>")[0]
        assert re.findall(r"\d+\.0(?=</)", headline) == [rate]
        assert CHECKPOINTS[checkpoint].wording in headline


def test_without_its_packages_it_says_so_in_one_line(run, tmp_path, no_bokeh):
    with pytest.raises(UserError, match=REFUSAL):
        cli.run(["report", str(run), "--out", str(tmp_path / "out")])
    assert not (tmp_path / "out").exists()


def test_a_suite_ends_well_without_them(tmp_path, capsys, no_bokeh):
    suite_command._write_page(tmp_path)
    assert capsys.readouterr().out.startswith("no page was written: this needs the package bokeh")


def test_what_is_wrong_is_one_line(tmp_path):
    done = subprocess.run(
        [sys.executable, "-P", "-m", "pigbench", "report", str(tmp_path), "--out", "x"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"pigbench: {tmp_path} is not a run: it has no config.json\n"
