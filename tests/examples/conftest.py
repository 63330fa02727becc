"""Examples as modules, and as commands."""

import importlib.util
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import pytest
import tyro

from pigbench.commands import generate

EXAMPLES = Path(__file__).parents[2] / "examples"


def load_example(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def run_example(name: str, *arguments: str | Path) -> ModuleType:
    module = load_example(name)
    tyro.cli(module.Example, args=list(map(str, arguments))).run()
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
