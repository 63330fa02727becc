"""The place of a page: a folder of its own."""

import contextlib
from collections.abc import Iterator
from pathlib import Path

from pigbench.errors import UserError
from pigbench.support import files, lock

PAGE, FILMS = "index.html", "films"
"""Contents of the folder: the page's file, and a folder of films if it has any."""


def require_own(out: Path) -> None:
    """Raise UserError unless a page can be written there: it replaces nothing but a page."""
    files.require_folder(out)
    if out.is_dir() and not files.entries(out) <= {PAGE, FILMS}:
        raise UserError(f"{out} is not an empty folder and holds no report: choose another")


@contextlib.contextmanager
def replacing(out: Path) -> Iterator[Path]:
    """An empty folder for a page, which then replaces `out`. Raises like `require_own`."""
    require_own(out)
    with lock.replacing_folder(out) as folder:
        yield folder
