"""Ctrl-C and SIGTERM: what a command was writing is undone, and its process ends at once.

Python's normal exit is avoided: a program that XLA runs may call into the interpreter at any moment
(MuJoCo runs in a host call), which is a segmentation fault while the interpreter shuts down.
"""

import contextlib
import os
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterator
from types import FrameType
from typing import NoReturn

_CALLERS = "pigbench.support.host_calls", "jax._src.callback"
"""The modules through which a compiled program calls into Python."""

SIGNALS = signal.SIGINT, signal.SIGTERM

_PATIENCE_SECONDS = 3.0
"""How long to wait for the main thread to receive a signal while it runs a compiled program."""


@contextlib.contextmanager
def leaving_at_once(farewell: Callable[[], str]) -> Iterator[None]:
    """A signal raises KeyboardInterrupt within the block, which then ends the process.

    The process prints `farewell()` on standard error and exits with 128 plus the signal's number.
    It does not wait for a main thread that does not receive the signal: files are intact at every
    moment. Does nothing outside the main thread, and for ignored signals, as under nohup.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    received: list[int] = []
    heard = threading.Event()

    def hear(number: int, frame: FrameType | None) -> None:
        if _is_in_host_call(frame):  # XLA would turn an exception into an error of its own
            _leave(number, farewell)
        received.append(number)
        heard.set()
        raise KeyboardInterrupt

    with _told_of_signals(lambda number: heard.wait(_PATIENCE_SECONDS) or _leave(number, farewell)):
        obeyed = [number for number in SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
        before = {number: signal.signal(number, hear) for number in obeyed}
        try:
            yield
        except BaseException:  # whatever KeyboardInterrupt has turned into on its way
            if received:
                _leave(received[0], farewell)
            raise
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)


@contextlib.contextmanager
def _told_of_signals(tell: Callable[[int], object]) -> Iterator[None]:
    """Call `tell` with the first signal's number, in a separate thread."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)

    def listen() -> None:
        number = os.read(reader, 1)
        if number:
            tell(number[0])
        while os.read(reader, 1):  # timeout(1) signals twice, and Python complains of a closed pipe
            pass
        os.close(reader)

    before = signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    threading.Thread(target=listen, name="signals", daemon=True).start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        os.close(writer)


def _is_in_host_call(frame: FrameType | None) -> bool:
    """Whether this code was called by a compiled program."""
    stack = () if frame is None else traceback.walk_stack(frame)
    return any(one.f_globals.get("__name__") in _CALLERS for one, _ in stack)


def _leave(number: int, farewell: Callable[[], str]) -> NoReturn:
    with contextlib.suppress(OSError, ValueError):  # nobody may be listening
        sys.stdout.flush()
        print(farewell(), file=sys.stderr, flush=True)
    os._exit(128 + number)
