"""Ctrl-C as a question that a run asks when it can answer to it."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

Interrupt = Callable[[], bool]


@contextmanager
def asked_to_stop(further: Interrupt | None = None) -> Iterator[Interrupt]:
    """Yield a question whether to stop: after Ctrl-C, or if ``further`` says so.

    A second Ctrl-C raises ``KeyboardInterrupt`` at once. Outside of the main thread, and where
    somebody else handles the signal, it is left alone.
    """
    pressed = threading.Event()

    def press(number: int, frame: FrameType | None) -> None:
        if pressed.is_set():
            raise KeyboardInterrupt
        pressed.set()

    ours = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )
    if ours:
        signal.signal(signal.SIGINT, press)
    try:
        yield lambda: pressed.is_set() or (further is not None and further())
    finally:
        if ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)
