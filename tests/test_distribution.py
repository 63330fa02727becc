"""What is released: versions agree, and the wheel alone does what the quickstart does."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
CODE = {"pigbench": "pigbench", "agents": "pigbench/agents", "envs": "pigbench/envs"}
"""Folder of the checkout -> where the wheel has it."""

DATA = "--episodes 2 --validation-episodes 1 --episode-length 31"
TRAIN = "--preset cpu --goals cubes --steps 4 --evaluate-every 2 --evaluation.episodes 1"
SMALL = "--agent.batch-size 8 --agent.actor-hidden-sizes 8 --agent.value-hidden-sizes 8"
QUICKSTART = [
    f"generate cube-single --out data {DATA}",
    f"train hjb-gcivl --data data --out run {TRAIN} {SMALL}",
    "table run --show methods milestones",
    "plot run --out curves.png",
]


def run(*command: str | Path, cwd: Path) -> str:
    """What a command prints, without the checkout's own way to find pigbench."""
    env = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run(command, cwd=cwd, env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    """Of the checkout's code, by `make dist`, in a copy of it."""
    copy = tmp_path_factory.mktemp("source")
    for name in (*CODE, "README.md", "LICENSE", "Makefile", "pyproject.toml"):
        source = ROOT / name
        (shutil.copytree if source.is_dir() else shutil.copy)(source, copy / name)
    make = ["make", "dist", "--old-file=.venv/installed", f"BIN={Path(sys.executable).parent}"]
    run(*make, cwd=copy)
    (found,) = (copy / "dist").glob("*.whl")
    return found


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory) -> Path:
    """The programs of a fresh environment: the wheel in it, and what it needs from this one."""
    home = tmp_path_factory.mktemp("venv")
    venv.create(home, symlinks=True)
    (site,) = home.glob("lib/python*/site-packages")
    (site / "needed.pth").write_text(sysconfig.get_path("purelib") + "\n")  # its .pth are not read
    python = home / "bin" / "python"
    pip = [python, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps"]
    run(*pip, "--ignore-installed", wheel, cwd=home)
    return home / "bin"


def test_versions_agree():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text())["version"] == version
    newest = re.search(r"^## \[.*?(?=^## |\Z)", (ROOT / "CHANGELOG.md").read_text(), re.M | re.S)
    assert newest and version in newest[0]


def test_the_wheel_holds_the_code(wheel):
    """By way of the source distribution, which lacks nothing either."""
    packed = set(zipfile.ZipFile(wheel).namelist())
    for folder, place in CODE.items():
        for path in (ROOT / folder).rglob("*"):
            if path.is_file() and path.suffix != ".pyc":
                assert f"{place}/{path.relative_to(ROOT / folder)}" in packed


@pytest.mark.slow
def test_the_wheel_alone_does_the_quickstart(installed, tmp_path):
    where = run(
        installed / "python", "-c", "import pigbench; print(pigbench.__file__)", cwd=tmp_path
    )
    assert Path(where).is_relative_to(installed.parent)
    *_, table, _ = [run(installed / "pigbench", *line.split(), cwd=tmp_path) for line in QUICKSTART]
    assert re.search(r"^\| hjb-gcivl +\| ", table, re.M)
    assert (tmp_path / "curves.png").read_bytes().startswith(b"\x89PNG")
