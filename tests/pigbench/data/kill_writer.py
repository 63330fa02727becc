"""Kills the writing of a data set at every single access to its folder, and takes it up again.

Run as a script with an empty folder: killing means forking, which a test process full of threads
must not do. Prints how many times it killed.
"""

import importlib.util
import os
import sys
from pathlib import Path
from types import ModuleType

WATCHED = {"open", "os.mkdir", "os.rename", "os.remove", "os.rmdir", "shutil.rmtree"}
KILLED = 9


def example() -> ModuleType:
    path = Path(__file__).parents[1] / "conftest.py"
    specification = importlib.util.spec_from_file_location("conftest", path)
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def die_at(access: int, folder: Path) -> None:
    """Ends this process, without any cleaning up, before the given access to the folder."""
    left = access

    def hook(event: str, arguments: tuple) -> None:
        nonlocal left
        if event in WATCHED and str(arguments[0]).startswith(str(folder)):
            if left == 0:
                os._exit(KILLED)
            left -= 1

    sys.addaudithook(hook)


def contents(folder: Path) -> dict[str, bytes]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def main(root: Path) -> None:
    write_dataset = example().write_dataset
    write_dataset(root / "expected")
    expected = contents(root / "expected")
    access, status = 0, KILLED
    while status == KILLED:
        folder = root / f"killed-{access}"
        child = os.fork()
        if child == 0:
            die_at(access, folder)
            write_dataset(folder)
            os._exit(0)
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        write_dataset(folder)
        assert contents(folder) == expected, f"killed at access {access}"
        access += 1
    assert status == 0, status
    print(access - 1)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
