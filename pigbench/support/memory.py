"""The memory at hand: what does not fit is rejected before it begins."""

import os
from collections.abc import Iterator
from pathlib import Path

from pigbench.errors import UserError

SHARERS = "PIGBENCH_SHARERS"
"""The environment variable that tells a suite's jobs how many of them share a machine."""

_BYTES_EACH = 4096
"""The least that one simulation takes (one cube, the C engine), or about what a sample does."""

_GROUPS = Path("proc/self/cgroup")
_LIMITS = {
    "": ("sys/fs/cgroup", "memory.max"),
    "memory": ("sys/fs/cgroup/memory", "memory.limit_in_bytes"),
}
"""Linux's control groups, by controller (version 2 names none): their folder and limit file."""


def available(root: Path = Path("/")) -> int:
    """Bytes of this machine's memory, or of what our container or batch job may use, if less.

    `root` is the folder that holds `proc` and `sys`.
    """
    physical = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return min([physical, *_limits(root)])


def share() -> int:
    """Bytes of the available memory for this process: the jobs of a suite have equal shares."""
    return available() // int(os.environ.get(SHARERS, 1))


def require_for(count: int, what: str = "simulations at once") -> None:
    """Raise UserError if so many simulations or samples need more than all of the memory."""
    need = _BYTES_EACH * count
    memory = available()
    if need > memory:
        raise UserError(
            f"{count:,} {what} take {need / 1e9:,.1f} GB at least, and this "
            f"machine has {memory / 1e9:,.1f}: choose fewer"
        )


def _limits(root: Path) -> Iterator[int]:
    """Limits in bytes of this process's control groups and of those that contain them."""
    groups = root / _GROUPS
    for line in groups.read_text().splitlines() if groups.exists() else ():
        _, controllers, group = line.split(":", 2)
        for controller in {*controllers.split(",")} & _LIMITS.keys():
            place, name = _LIMITS[controller]
            inner = root / place / group.lstrip("/")
            # Inside a container, its group may be mounted as the root, whatever its name here.
            for folder in (inner, *inner.parents[: len(Path(group).parts) - 1]):
                limit = folder / name
                text = limit.read_text().strip() if limit.exists() else "max"
                if text != "max":
                    yield int(text)
