"""Methods of one's own: the example, as a file and as an installed package."""

import importlib.metadata
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from pigbench import cli, plugins
from pigbench.errors import UserError

ROOT = Path(__file__).parents[2]
PAGE, FILE = ROOT / "docs" / "extending.md", ROOT / "examples" / "huber_bc.py"
SMALL = [
    *("--preset", "cpu", "--steps", "4", "--evaluate-every", "4", "--evaluation.episodes", "1"),
    *("--agent.batch-size", "8", "--agent.actor-hidden-sizes", "8", "--agent.delta", "0.2"),
]
CHECKOUT_CODE = "import sys; from pigbench import cli; sys.argv[0] = 'pigbench'; cli.main()"


def pigbench(*arguments: str | Path, path: Path | None = None) -> subprocess.CompletedProcess[str]:
    """The command line in a process of its own, with a folder of installed packages."""
    paths = [str(path), os.environ["PYTHONPATH"]] if path else [os.environ["PYTHONPATH"]]
    return subprocess.run(
        [sys.executable, "-c", CHECKOUT_CODE, *arguments],
        env=os.environ | {"PYTHONPATH": os.pathsep.join(paths)},
        capture_output=True,
        text=True,
    )


@pytest.fixture(scope="module")
def package(tmp_path_factory) -> Path:
    """The page's package, as its reader would write it."""
    folder = tmp_path_factory.mktemp("package")
    shutil.copy(FILE, folder)
    (project,) = re.findall(r"```toml\n(.*?)```", PAGE.read_text(), re.DOTALL)
    (folder / "pyproject.toml").write_text(project)
    return folder


@pytest.fixture(scope="module")
def installed(package, tmp_path_factory) -> Path:
    """The folder that pip installs it into."""
    site = tmp_path_factory.mktemp("site")
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    subprocess.run(
        [*pip, "--no-deps", "--no-build-isolation", "--target", site, package], check=True
    )
    return site


def test_the_pages_file_is_a_method():
    assert '--8<-- "examples/huber_bc.py"' in PAGE.read_text()
    listed = pigbench("list", "methods", "--plugin", FILE)
    assert "huber-bc" in listed.stdout
    assert "behaviour cloning with the Huber loss" in listed.stdout


def test_the_pages_package_trains_evaluates_and_is_tabled(installed, played, tmp_path):
    run = tmp_path / "run"
    for command in (
        ("train", "huber-bc", "--data", played, "--out", run, *SMALL),
        ("evaluate", run, "--episodes", "2"),
    ):
        done = pigbench(*command, path=installed)
        assert done.returncode == 0, done.stderr
    table = pigbench("table", run, path=installed).stdout
    assert re.search(r"\| huber-bc +\| +0\.0 \|", table)
    # Without the package, its runs can still be tabled, but not acted in.
    assert pigbench("table", run).stdout == table
    refused = pigbench("evaluate", run)
    assert refused.returncode == 2
    assert "unknown method 'huber-bc'" in refused.stderr
    assert "add --plugin FILE" in refused.stderr


def test_the_pages_subclass_trains(played, tmp_path):
    """With the weights of the page, which leave the value loss as it is."""
    (source,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(), re.DOTALL)
    plugin, run = tmp_path / "positive.py", tmp_path / "run"
    plugin.write_text(source)
    options = [word for word in SMALL if word not in ("--agent.delta", "0.2")]
    options += ["--agent.value-hidden-sizes", "8", "--agent.rest", "0.5", "--log-every", "1"]
    done = pigbench(
        "train", "positive-gcivl", "--plugin", plugin, "--data", played, "--out", run, *options
    )
    assert done.returncode == 0, done.stderr
    logged = [json.loads(line) for line in (run / "metrics.jsonl").read_text().splitlines()]
    assert {"value/td_loss", "actor/loss"} <= logged[0].keys()
    assert "actor/advantage" not in logged[0]  # GCIVL's own loss has it


def test_a_file_is_run_once(tmp_path):
    plugin = tmp_path / "count.py"
    plugin.write_text(f"with open({str(tmp_path / 'log')!r}, 'a') as log: log.write('run\\n')")
    plugins.load_file(plugin)
    plugins.load_file(plugin)
    assert (tmp_path / "log").read_text() == "run\n"


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (None, r"does not exist: name a Python file, with its folder"),
        ("import nosuchmodule", r"does not load: ModuleNotFoundError: .*nosuchmodule"),
        ("def (", r"does not load: SyntaxError"),
        (
            "from pigbench import agents; agents.register(agents.get('gcbc'))",
            r"'gcbc' is already registered",
        ),
    ],
)
def test_what_is_wrong_with_a_plugin_is_said(tmp_path, content, complaint):
    plugin = tmp_path / "plugin.py"
    if content is not None:
        plugin.write_text(content)
    for _ in range(2):
        with pytest.raises(UserError, match=rf"plugin .*plugin\.py.*{complaint}"):
            cli.run(["list", "methods", "--plugin", str(plugin)])


def test_a_broken_package_is_named(monkeypatch):
    entry = importlib.metadata.EntryPoint("torn", "nosuchmodule:Torn", plugins.ENTRY_POINTS)
    monkeypatch.setattr(importlib.metadata, "entry_points", lambda group: [entry])
    with pytest.warns(UserWarning, match=r"'torn' \(nosuchmodule:Torn\) does not load.* without"):
        plugins.load_installed()


def test_a_broken_package_costs_a_line_and_its_method(package, tmp_path):
    """Beside one that is whole, for a command that needs neither and for one that needs it."""
    for name in ("torn_first", "torn_last"):
        info = tmp_path / f"{name}-1.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1\n")
        (info / "entry_points.txt").write_text(f"[pigbench.agents]\n{name} = {name}:X\n")
        (tmp_path / f"{name}.py").write_text("raise RuntimeError('first\\nsecond')\n")
    listed = pigbench("list", "methods", path=tmp_path)
    assert listed.returncode == 0
    assert "hjb-gcivl" in listed.stdout
    lines = sorted(listed.stderr.splitlines())
    assert len(lines) == 2
    for name, line in zip(("torn_first", "torn_last"), lines, strict=True):
        assert line.startswith(f"pigbench: entry point '{name}' ({name}:X) does not load: ")
        assert line.endswith(f"{name}.py, line 1); going on without it")
    wanted = pigbench("train", "torn_last", "--data", "d", "--out", "r", path=tmp_path)
    assert wanted.returncode == 2
    assert wanted.stderr.splitlines()[-1].startswith("pigbench: unknown method 'torn_last'")


def test_a_file_finds_its_neighbours(tmp_path, capsys):
    (tmp_path / "a_neighbour_of_mine.py").write_text("NAME = 'named-by-a-neighbour'")
    (tmp_path / "random.py").write_text("raise RuntimeError('hides what comes with Python')")
    (tmp_path / "plugin.py").write_text(
        "import dataclasses, random\n"
        "from a_neighbour_of_mine import NAME\n"
        "from pigbench import agents\n"
        "agents.register(dataclasses.replace(agents.get('gcbc'), name=NAME))\n"
    )
    cli.run(["list", "methods", "--plugin", str(tmp_path / "plugin.py")])
    assert "named-by-a-neighbour" in capsys.readouterr().out


@pytest.mark.parametrize("what", ["1 / 0", "raise SystemExit(3)", "raise ValueError('a\\nb')"])
def test_an_exception_is_one_line_that_names_its_place(what, tmp_path):
    (tmp_path / "plugin.py").write_text(f"\n\n{what}\n")
    done = pigbench("list", "methods", "--plugin", tmp_path / "plugin.py")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert done.stderr.endswith("plugin.py, line 3)\n")


def test_a_plugin_needs_a_file(tmp_path):
    (tmp_path / "loop.py").symlink_to("loop.py")
    with pytest.raises(UserError, match=r"loop\.py does not exist"):
        plugins.load_file(tmp_path / "loop.py")
    with pytest.raises(UserError, match=r"--plugin: expected one argument"):
        cli.run(["list", "methods", "--plugin"])
