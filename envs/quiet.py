"""Imports without the greetings that mujoco-mjx and NVIDIA Warp print."""

import contextlib
import io
from collections.abc import Iterator


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Nothing that is imported within prints, and Warp is told to mention errors only."""
    with contextlib.redirect_stdout(io.StringIO()):
        with contextlib.suppress(ImportError):
            import warp  # pyright: ignore[reportMissingImports]

            warp.config.log_level = warp.LOG_ERROR
        yield
