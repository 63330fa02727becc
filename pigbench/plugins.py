"""Methods from elsewhere: modules imported here call `register` for each of their methods.

A file may register environments, measures, physics engines and loggers too.
"""

import contextlib
import importlib.metadata
import importlib.util
import sys
import traceback
import warnings
from collections.abc import Iterator
from pathlib import Path

from pigbench.errors import UserError

ENTRY_POINTS = "pigbench.agents"
"""The group under which an installed package declares its methods."""


def load_installed() -> None:
    """Import the methods that installed packages declare; warns about those that fail to load."""
    for entry in importlib.metadata.entry_points(group=ENTRY_POINTS):
        try:
            with _explaining(f"entry point {entry.name!r} ({entry.value})"):
                entry.load()
        except UserError as error:
            warnings.warn(f"{error}; going on without it", stacklevel=2)


def load_file(path: Path) -> None:
    """Run a Python file, once, that registers its methods. It can import modules beside it.

    Raises UserError if it does not exist or does not run.
    """
    if not path.exists():
        raise UserError(f"plugin {path} does not exist: name a Python file, with its folder")
    if not path.is_file() or path.suffix != ".py":
        raise UserError(f"plugin {path} is not a Python file, NAME.py")
    name = f"{ENTRY_POINTS}:{path.resolve()}"
    if name in sys.modules:
        return
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    beside = str(path.resolve().parent)
    if beside not in sys.path:
        sys.path.append(beside)  # last, so that a neighbour hides no installed module
    sys.modules[name] = module  # dataclasses look up their defining module
    try:
        with _explaining(f"plugin {path}"):
            spec.loader.exec_module(module)
    except UserError:
        del sys.modules[name]
        raise


def loaded_files() -> list[str]:
    """The files that `load_file` has run."""
    prefix = f"{ENTRY_POINTS}:"
    return [name.removeprefix(prefix) for name in sys.modules if name.startswith(prefix)]


@contextlib.contextmanager
def _explaining(plugin: str) -> Iterator[None]:
    try:
        yield
    except UserError as error:
        raise UserError(f"{plugin}: {error}") from error
    except (Exception, SystemExit) as error:
        raise UserError(
            f"{plugin} does not load: {type(error).__name__}: {error}{_place(error)}"
        ) from error


def _place(error: BaseException) -> str:
    """Where the error arose in a plugin's code: the innermost line that is in a file."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if not frame.filename.startswith("<")]
    last = own[-1] if own else None
    return f" ({last.filename}, line {last.lineno})" if last else ""
