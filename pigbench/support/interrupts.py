"""Ctrl-C and SIGTERM: what a command was writing is undone, and its process ends at once.

Not by Python's own way out: a program that XLA runs may call into the interpreter at any moment
(MuJoCo is behind a host callback), and while that is taken down this is a segmentation fault.
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

_CALLBACKS = "jax._src.callback"

SIGNALS = signal.SIGINT, signal.SIGTERM

_PATIENCE_SECONDS = 3.0
"""For how long the main thread may not hear a signal because a compiled program has it."""


@contextlib.contextmanager
def leaving_at_once(farewell: Callable[[], str]) -> Iterator[None]:
    """A signal within the block raises KeyboardInterrupt there; outside, it ends the process.

    It then says `farewell()` on standard error, and its status is 128 plus the signal's number. A
    main thread that does not hear the signal is not waited for: files are whole at every moment.
    Does nothing outside the main thread, and to signals that are ignored, as by nohup.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    received: list[int] = []
    heard = threading.Event()

    def hear(number: int, frame: FrameType | None) -> None:
        if _is_in_callback(frame):  # XLA would make an error of its own of an exception
            _leave(number, farewell)
        received.append(number)
        heard.set()
        raise KeyboardInterrupt

    with _told_of_signals(lambda number: heard.wait(_PATIENCE_SECONDS) or _leave(number, farewell)):
        obeyed = [number for number in SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
        before = {number: signal.signal(number, hear) for number in obeyed}
        try:
            yield
        except BaseException:  # whatever KeyboardInterrupt has become on its way
            if received:
                _leave(received[0], farewell)
            raise
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)


@contextlib.contextmanager
def _told_of_signals(tell: Callable[[int], object]) -> Iterator[None]:
    """Calls `tell` with the first signal's number, in a thread of its own."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)

    def listen() -> None:
        number = os.read(reader, 1)
        if number:
            tell(number[0])
        while os.read(reader, 1):  # timeout(1), for one, signals twice: Python minds a closed pipe
            pass
        os.close(reader)

    before = signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
    threading.Thread(target=listen, name="signals", daemon=True).start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        os.close(writer)


def _is_in_callback(frame: FrameType | None) -> bool:
    """Is this code that a compiled program has called?"""
    stack = () if frame is None else traceback.walk_stack(frame)
    return any(one.f_globals.get("__name__") == _CALLBACKS for one, _ in stack)


def _leave(number: int, farewell: Callable[[], str]) -> NoReturn:
    with contextlib.suppress(OSError, ValueError):  # nobody may be listening
        sys.stdout.flush()
        print(farewell(), file=sys.stderr, flush=True)
    os._exit(128 + number)
