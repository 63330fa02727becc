"""This machine's memory: simulations that do not fit are rejected before they begin."""

import os

from pigbench.errors import UserError

_BYTES_EACH = 4096
"""The least that one simulation takes (one cube, the C engine)."""


def physical() -> int:
    """Size of this machine's memory in bytes."""
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def require(simulations: int) -> None:
    """Raise UserError if so many simulations at once need more than all of the memory."""
    need = _BYTES_EACH * simulations
    memory = physical()
    if need > memory:
        raise UserError(
            f"{simulations:,} simulations at once take {need / 1e9:,.1f} GB at least, and this "
            f"machine has {memory / 1e9:,.1f}: choose fewer"
        )
