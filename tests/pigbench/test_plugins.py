"""Methods of one's own: the very example of the README, as a file and as an installed package."""

import importlib.metadata
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from pigbench import cli, plugins
from pigbench.errors import UserError

README = Path(__file__).parents[2] / "README.md"
SMALL = [
    *("--preset", "cpu", "--steps", "4", "--evaluate-every", "4", "--evaluation.episodes", "1"),
    *("--agent.batch-size", "8", "--agent.actor-hidden-sizes", "8", "--agent.delta", "0.2"),
]
GENERATE = ["generate", "cube-single", "--episodes", "1", "--validation-episodes", "0"]
CHECKOUT_CODE = "import sys; from pigbench import cli; sys.argv[0] = 'pigbench'; cli.main()"


def pigbench(*arguments: str | Path, path: Path | None = None) -> subprocess.CompletedProcess[str]:
    """The command line in a process of its own, with a folder of installed packages."""
    return subprocess.run(
        [sys.executable, "-c", CHECKOUT_CODE, *arguments],
        env=os.environ | ({"PYTHONPATH": str(path)} if path else {}),
        capture_output=True,
        text=True,
    )


def readme_block(language: str, containing: str) -> str:
    blocks = re.findall(rf"```{language}\n(.*?)```", README.read_text(), re.DOTALL)
    (block,) = (block for block in blocks if containing in block)
    return block


@pytest.fixture(scope="module")
def package(tmp_path_factory) -> Path:
    """The README's package, as its reader would write it."""
    folder = tmp_path_factory.mktemp("package")
    (folder / "huber_bc.py").write_text(readme_block("python", "class HuberBC("))
    (folder / "pyproject.toml").write_text(readme_block("toml", "huber_bc:HuberBC"))
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


@pytest.fixture(scope="module")
def data(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("plugins") / "data"
    cli.run([*GENERATE, "--episode-length", "31", "--out", str(folder)])
    return folder


def test_the_readmes_file_is_a_method(package):
    listed = pigbench("list", "methods", "--plugin", package / "huber_bc.py")
    assert "huber-bc" in listed.stdout
    assert "behaviour cloning with Huber's loss" in listed.stdout


def test_the_readmes_package_trains_evaluates_and_is_tabled(installed, data, tmp_path):
    run = tmp_path / "run"
    for command in (
        ("train", "huber-bc", "--data", data, "--out", run, *SMALL),
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


def test_a_file_is_run_once(tmp_path):
    plugin = tmp_path / "count.py"
    plugin.write_text(f"open({str(tmp_path / 'log')!r}, 'a').write('run\\n')")
    plugins.load_file(plugin)
    plugins.load_file(plugin)
    assert (tmp_path / "log").read_text() == "run\n"


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (None, r"no Python file: name an existing one"),
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
    with pytest.raises(UserError, match=r"'torn' \(nosuchmodule:Torn\) does not load"):
        plugins.load_installed()


def test_a_plugin_needs_a_file():
    with pytest.raises(UserError, match=r"--plugin: expected one argument"):
        cli.run(["list", "methods", "--plugin"])
