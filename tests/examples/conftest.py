"""Examples as modules, and as commands."""

import importlib.util
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import pytest

from pigbench import cli
from pigbench.commands import generate

EXAMPLES = Path(__file__).parents[2] / "examples"


def load_example(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def run_example(name: str, *arguments: str | Path) -> ModuleType:
    module = load_example(name)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, name, module)  # where Tyro looks for the source of its help
        patch.setattr("sys.argv", [f"{name}.py", *map(str, arguments)])
        cli.script(module.Example)
    return module


@pytest.fixture(scope="module", autouse=True)
def small_shards() -> Iterator[None]:
    """Of one episode: batches of 50 are as many computations, if all but one are vacant."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(generate, "_SHARD_OF_HOST", 1)
        yield


@pytest.fixture(scope="session")
def examples() -> Path:
    return EXAMPLES


@pytest.fixture(scope="session")
def load() -> Callable[[str], ModuleType]:
    return load_example


@pytest.fixture(scope="session")
def run() -> Callable[..., ModuleType]:
    """Runs an example as its command would, and gives its module."""
    return run_example
