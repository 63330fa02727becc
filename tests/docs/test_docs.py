"""README and documentation: what they show parses, runs and builds."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from pigbench import cli

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", page.read_text(), re.DOTALL)


def commands(page: Path) -> list[list[str]]:
    """The arguments of every `pigbench` in the page's blocks of shell."""
    lines = "\n".join(blocks(page, "sh")).replace("\\\n", " ").splitlines()
    words = (shlex.split(line, comments=True) for line in lines)
    return [line[1:] for line in words if line and line[0] == "pigbench"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_commands_have_the_options_that_pages_show(page):
    for arguments in commands(page):
        # Those are run, in test_plugins.py and test_examples.py.
        if "--plugin" not in arguments and "huber-bc" not in arguments:
            cli.parse(arguments)


def test_the_python_of_the_readme_trains_and_evaluates(tmp_path):
    (script,) = blocks(ROOT / "README.md", "python")
    for shown, small in {
        "import episodes\n": "import episodes\nfrom pigbench.training.evaluate import Evaluation\n",
        "episodes=200": "episodes=1, validation_episodes=0",
        "steps=16_000": "steps=4, evaluation=Evaluation(1)",
        "== 16_000": "== 4",
    }.items():
        assert shown in script
        script = script.replace(shown, small)
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert 0 <= float(done.stdout.splitlines()[-1]) <= 1


def test_the_site_builds(tmp_path):
    """Strictly: no link and no name of the API leads nowhere."""
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", tmp_path],
        cwd=ROOT,
        env=os.environ | {"NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert "hjb_residual" in (tmp_path / "api" / "index.html").read_text()
    assert (tmp_path / "results" / "study" / "curves.png").exists()
    assert "PolicyAgent" in (tmp_path / "extending" / "index.html").read_text()  # of a snippet
