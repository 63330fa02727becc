"""Imports without the messages that mujoco-mjx and NVIDIA Warp print on import."""

import contextlib
import io
from collections.abc import Iterator


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Suppress what imports inside the block print, and have Warp report errors only."""
    with contextlib.redirect_stdout(io.StringIO()):
        with contextlib.suppress(ImportError):
            import warp  # pyright: ignore[reportMissingImports]

            warp.config.log_level = warp.LOG_ERROR
        yield
