"""README and documentation: what they show parses, runs and builds."""

import glob
import os
import re
import runpy
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from pigbench import agents, cli, plugins
from pigbench.agents import registry
from pigbench.commands import parity
from pigbench.data import dataset

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def blocks(page: Path, language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", page.read_text(), re.DOTALL)


NETWORKS = "--agent.batch-size 4 --agent.actor-hidden-sizes 8"
PICTURE = "--size.width 64 --size.height 48"

SMALL = {
    "generate": "--episodes 4 --validation-episodes 1 --episodes-per-shard 4",
    "generate cube-single": "--episode-length 9",
    "generate cube-corners": "--episode-length 9",
    "train": f"--steps 2 --evaluate-every 2 --evaluation.episodes 1 {NETWORKS}",
    "train gcivl": "--agent.value-hidden-sizes 8",
    "train lipschitz-gcivl": "--agent.value-hidden-sizes 8",
    "train hjb-gcivl": "--agent.value-hidden-sizes 8",
    "evaluate": "--episodes 1 --replace",
    "evaluate runs/robot-0": "--noise 5",
    "analyze": "--samples 20",
    "render": PICTURE,
    "render runs/hjb-0": "--task 1",
    "data render": PICTURE,
    "parity": "--episodes 1",
    "parity --": "--engine mujoco --physics exact",
    "bench train": "--turns.turns 1 --turns.seconds 0.01",
    "toy": "--seeds 1 --settings.steps 2 --settings.hidden-sizes 8",
}
"""What is added to commands that begin so: of two values of an option, the later one counts."""

SMALL_SUITE = {
    '["gcivl", "pi-h-flow-hjb-gcivl"]': '["gcbc"]',
    "[0, 1, 2]": "[0]",
    "5_000": "2",
    "episodes = 10": "episodes = 1",
    "1_000_000": "20",
    "20_000": "2",
    "learning_rate = 1e-3": "batch_size = 4\nactor_hidden_sizes = [8]",
    "# [variants.full]": "[data]\nepisode_transitions = 20\nvalidation_episodes = 0",
}

NEED_MORE = {
    "data push": "the hub: see test_hub.py",
    "data pull": "the hub: see test_hub.py",
    "suite paper-flat --out /shared/runs/flat": "a cluster: see test_cluster.py",
}


def commands(page: Path) -> list[str]:
    """Every command of pigbench in the page's blocks of shell, on one line."""
    lines = "\n".join(blocks(page, "sh")).replace("\\\n", " ").splitlines()
    return [line.removeprefix("pigbench ") for line in lines if line.startswith("pigbench ")]


def small(command: str) -> list[str]:
    """Its arguments, as a shell would give them, and those that make it small."""
    words = shlex.split(command, comments=True)
    words = [file for word in words for file in sorted(glob.glob(word)) or [word]]
    if words[0] == "suite" and words[1] != "status":
        words[1] = "small.toml"
    begins = " ".join(words) + " --"
    return words + [
        word
        for start, more in SMALL.items()
        if begins.startswith(start + " ")
        for word in more.split()
    ]


@pytest.fixture
def folder(drawing, short_episodes, tmp_path, monkeypatch) -> Iterator[Path]:
    """Where a reader would be, with the files that the pages say they have."""
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    (suite,) = blocks(ROOT / "docs" / "suites.md", "toml")
    for shown, small in SMALL_SUITE.items():
        assert shown in suite
        suite = suite.replace(shown, small)
    (tmp_path / "small.toml").write_text(suite)
    monkeypatch.chdir(tmp_path)
    own = {"huber-bc", "lipschitz-gcivl"}
    others = {name: agents.get(name) for name in agents.names() if name not in own}
    monkeypatch.setattr(registry, "_METHODS", others)
    monkeypatch.setattr(parity, "_EPISODE_LENGTH", 200)
    for module in _plugins():  # of other tests, which a suite would load too
        monkeypatch.delitem(sys.modules, module)
    with short_episodes():
        yield tmp_path
    for module in _plugins():
        del sys.modules[module]


def _plugins() -> list[str]:
    return [f"{plugins.ENTRY_POINTS}:{file}" for file in plugins.loaded_files()]


def test_every_command_runs(folder):
    """Small, in the order in which one reads them, in one folder."""
    write_logs = runpy.run_path(str(ROOT / "examples" / "own_log.py"))["write_logs"]
    for page in PAGES:
        for command in commands(page):
            if command.startswith("data import logs"):
                write_logs(dataset.load(folder / "data" / "robot"), folder / "logs")
            if not command.startswith(tuple(NEED_MORE)):
                cli.run(small(command))


def test_the_python_of_the_readme_trains_and_evaluates(tmp_path):
    (script,) = blocks(ROOT / "README.md", "python")
    for shown, small in {
        "import episodes\n": (
            "import episodes\nfrom pigbench.evaluation.settings import Evaluation\n"
        ),
        "episodes=200": "episodes=1, validation_episodes=0, episode_length=21",
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


def test_the_python_of_environments_runs(drawing):
    for script in blocks(ROOT / "docs" / "environments.md", "python"):
        assert "64" in script
        exec(script.replace("64", "2"), {})


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
