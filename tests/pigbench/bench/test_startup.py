import json
import subprocess
import sys
from pathlib import Path

import pytest

from pigbench.bench import startup
from pigbench.commands.parsing import parse
from pigbench.commands.registry import COMMANDS
from pigbench.errors import UserError
from pigbench.suite import spec

# What a look at files and tables must not import: each takes a second or more.
HEAVY = ("jax", "brax", "mujoco.mjx", "flax")
LIGHT = (
    "--help",
    "list envs",
    "list methods",
    "data info data",
    "table RUN",
    "plot RUN --out F.png",
    "report RUN",
    "report SUITE",
    "suite status SUITE",
)
HEAVY_FOR_HELP = (*HEAVY, "mujoco", "matplotlib", "orbax.checkpoint")

HELP = f"""
import contextlib, io, json, sys
from pigbench import cli

found = {{}}
for name in {list(COMMANDS)}:
    before = set(sys.modules)
    sys.argv = ["pigbench", *name.split(), "--help"]
    with contextlib.redirect_stdout(io.StringIO()) as printed, contextlib.suppress(SystemExit):
        cli.main()
    heavy = [module for module in {HEAVY_FOR_HELP} if module in sys.modules.keys() - before]
    found[name] = printed.getvalue(), heavy
print(json.dumps(found))
"""

SUITE = """
methods = ["gcivl"]
seeds = [0]
evaluation.every = 100
environments = [{name = "cube-single", transitions = 1_000, steps = 200}]
"""


@pytest.fixture
def place(data, make_run) -> Path:
    """A folder with `data`, a RUN and the state of a SUITE."""
    folder = data.parent
    make_run(folder / "RUN", {100: [[1, 0], [1, 1]]})
    (folder / "suite.toml").write_text(SUITE)
    (folder / "SUITE").mkdir()
    spec.write(folder / "SUITE/suite.json", spec.read(folder / "suite.toml"))
    return folder


@pytest.mark.parametrize("command", LIGHT)
def test_looking_needs_no_jax(command, place):
    code = (
        "import sys\nfrom pigbench import cli\n"
        "try:\n    cli.main()\nexcept SystemExit as stop:\n    assert not stop.code\n"
        f"print([name for name in {HEAVY} if name in sys.modules])"
    )
    arguments = [sys.executable, "-c", code, *command.split()]
    run = subprocess.run(arguments, capture_output=True, text=True, check=True, cwd=place)
    assert len(run.stdout.splitlines()) > 1
    assert run.stdout.splitlines()[-1] == "[]"


@pytest.fixture(scope="module")
def helps() -> dict[str, tuple[str, list[str]]]:
    """By command: its help, and heavy modules that it imports as the first of all commands."""
    done = subprocess.run([sys.executable, "-c", HELP], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


@pytest.mark.parametrize("name", list(COMMANDS))
def test_help_imports_nothing_heavy(name, helps):
    text, heavy = helps[name]
    assert text.startswith(f"usage: pigbench {name} ")
    assert not heavy


def test_work_is_measured_with_an_empty_cache_and_again(monkeypatch):
    """Each turn has a cache of its own, and each round a folder for what the commands write."""
    calls = []

    def seconds(arguments, *, folder, environment):
        parse(arguments)  # raises UserError unless there is such a command with such options
        calls.append((environment["JAX_COMPILATION_CACHE_DIR"], folder, arguments[0]))
        assert not list(folder.iterdir())
        return float(len(calls))

    monkeypatch.setattr(startup, "seconds", seconds)
    taken = startup.measure_work(2)
    names = [name for *_, name in calls]
    assert names == ["generate", "train", "evaluate"] * 4
    assert len({cache for cache, *_ in calls}) == 2
    assert len({folder for _, folder, _ in calls}) == 4
    header, generate, *_ = startup.table(taken)
    assert header == ("pigbench", "empty cache", "filled cache")
    assert generate[1:] == ("4.00", "7.00")  # medians of 1 and 7, of 4 and 10


def test_a_commands_processor_time_is_measured():
    assert 0.01 < startup.seconds(["--help"]) < 5
    with pytest.raises(UserError, match=r"pigbench nonsense failed: .*unknown command"):
        startup.seconds(["nonsense"])
