"""This machine's memory: simulations that do not fit are refused before they begin."""

import os

from pigbench.errors import UserError

_BYTES_EACH = 4096
"""What one simulation takes at least (one cube, the C engine)."""


def physical() -> int:
    """Bytes of this machine's memory."""
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")


def require(simulations: int) -> None:
    """Raises UserError if so many simulations at once need more than all of the memory."""
    need = _BYTES_EACH * simulations
    memory = physical()
    if need > memory:
        raise UserError(
            f"{simulations:,} simulations at once take {need / 1e9:,.1f} GB at least, and this "
            f"machine has {memory / 1e9:,.1f}: choose fewer"
        )
