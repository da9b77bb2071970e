"""Signals that end a program: a run polls them between steps, and where a step takes long.

These are Ctrl-C, what batch systems send before they kill (SIGTERM), and the loss of the
terminal (SIGHUP). Within ``asked_to_stop`` they wait for the next query. Loops that may last
longer than a second without one, such as Newton's method, call ``give_way`` in each round.
"""

import atexit
import os
import signal
import sys
import threading
import time as clock
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from queue import Empty, Queue
from types import FrameType
from typing import Any, TypeVar, cast

T = TypeVar("T")
Interrupt = Callable[[], bool]
SIGNALS = [
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)
]
_innermost: ContextVar["StopRequest | None"] = ContextVar("asked to stop", default=None)
_left: list[threading.Thread] = []  # what ``waiting_for`` left
_ATEXIT: Any = atexit  # whose stub does not know what runs its functions
PATIENCE = 0.5  # wall time after which work without a query gives way [s]
SIGNALLED = 128  # exit codes of what ends by a signal count from here


class Terminated(KeyboardInterrupt):
    """A signal other than that of Ctrl-C ended the program."""

    def __init__(self, number: int):
        super().__init__(signal.Signals(number).name)
        self.signal = number


class Halted(BaseException):
    """A loop gave way in the middle of its work, whose objects are not to be used further."""


class StopRequest:
    """The question whether to stop.

    Attributes:
        answered: Whether it was asked, and the answer was yes.
        asked: When it was asked last [s], by the monotonic clock.
    """

    def __init__(self, further: Interrupt | None = None):
        self.answered = False
        self.asked = clock.monotonic()
        self._signal: int | None = None
        self._further = further

    @property
    def signal(self) -> int | None:
        """Return the number of the first signal; None before it."""
        return self._further.signal if isinstance(self._further, StopRequest) else self._signal

    @property
    def is_late(self) -> bool:
        """Return whether a signal arrived after the last query."""
        return self._signal is not None and not self.answered

    def take(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal: the first one is an answer, the second ends the program at once."""
        if self._signal is not None:
            _end(number, frame)
        self._signal = number

    def __call__(self) -> bool:
        self.asked = clock.monotonic()
        further = self._further is not None and self._further()
        self.answered = self._signal is not None or further
        return self.answered


def exit_code(number: int | None) -> int:
    """Return the exit code of a program that a signal has ended, by default that of Ctrl-C."""
    return SIGNALLED + (signal.SIGINT if number is None else number)


def interruption(number: int | None) -> KeyboardInterrupt:
    """Return the exception for a signal, by default for Ctrl-C."""
    return KeyboardInterrupt() if number in (None, signal.SIGINT) else Terminated(number)


@contextmanager
def asked_to_stop(further: Interrupt | None = None) -> Generator[StopRequest]:
    """Yield a question whether to stop: after a signal, or if ``further`` says so.

    Outside of the main thread, and where other code handles a signal, its handler stays.

    Raises:
        KeyboardInterrupt: At the end, if a signal arrived after the last query.
    """
    stop = StopRequest(further)
    with _handled(stop.take):
        former = _innermost.set(stop)
        try:
            yield stop
        finally:
            _innermost.reset(former)
    if stop.is_late:
        raise interruption(stop.signal)


def give_way() -> None:
    """Leave the loop that calls this if a stop is asked for, and the last query was long ago.

    What takes less time than ``PATIENCE`` is brought to its end, where a run can be saved.

    Raises:
        Halted: That is so.
    """
    stop = _innermost.get()
    if stop is not None and clock.monotonic() - stop.asked >= PATIENCE and stop():
        raise Halted


def waiting_for(work: Callable[[], T]) -> T:
    """Return the result of work that takes long without running Python, such as a factor.

    A thread does it, so that signals are handled meanwhile; after one, it is left alone. Python
    cannot end before it does; see ``end_at_once``.

    Raises:
        Halted: As ``give_way``; and all that ``work`` raises.
    """
    results: Queue[tuple[T | None, BaseException | None]] = Queue()

    def do() -> None:
        try:
            results.put((work(), None))
        except BaseException as error:
            results.put((None, error))

    thread = threading.Thread(target=do)
    thread.start()
    try:
        while True:
            with suppress(Empty):
                result, error = results.get(timeout=PATIENCE / 2)
                break
            give_way()
    except BaseException:
        _left.append(thread)
        raise
    if error is not None:
        raise error
    return cast(T, result)


def end_at_once(code: int) -> None:
    """End the program if work was left in the middle, for which Python would wait.

    Args:
        code: Its exit code.
    """
    if any(thread.is_alive() for thread in _left):
        _ATEXIT._run_exitfuncs()
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):  # closed by whoever read it
                stream.flush()
        os._exit(code)


@contextmanager
def ending() -> Generator[None]:
    """Let signals end the block as Ctrl-C does: files are closed."""
    with _handled(_end):
        yield


@contextmanager
def _handled(handler: Callable[[int, FrameType | None], None]) -> Generator[None]:
    """Handle the signals that nobody else does, or that ``ending`` would."""
    ours = (signal.SIG_DFL, signal.default_int_handler, _end)
    former = {}
    if threading.current_thread() is threading.main_thread():
        former = {number: signal.getsignal(number) for number in SIGNALS}
        former = {number: one for number, one in former.items() if one in ours}
    for number in former:
        signal.signal(number, handler)
    try:
        yield
    finally:
        for number, one in former.items():
            signal.signal(number, one)


def _end(number: int, frame: FrameType | None) -> None:
    """End the program, through everything that is still to be closed."""
    raise interruption(number)
