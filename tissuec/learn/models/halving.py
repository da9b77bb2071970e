"""Work of many equal parts, half of which a second process does where one can be split off."""

import mmap
import os
import signal
from collections.abc import Callable

import numpy as np

from tissuec.network import Floats
from tissuec.running.twin import Twin


def all_rows(row: Callable[[int], Floats], count: int, width: int) -> Floats:
    """Return row(0), row(1), …, shape (count, width).

    Every other one is left to a second process; where that fails at one, it is done here, so
    that an error is raised as if there were one process only.
    """
    if count < 2 or not Twin.is_possible():
        return np.array([row(k) for k in range(count)]).reshape(count, width)
    memory = mmap.mmap(-1, 8 * count * (width + 1))
    rows = np.frombuffer(memory, count=count * (width + 1)).reshape(count, width + 1)
    parent, child = os.getpid(), os.fork()
    if not child:
        try:  # Nothing of the parent's may be cleaned up here, hence no ordinary exit.
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            for k in range(1, count, 2):
                if os.getppid() == parent:
                    _fill(rows, row, k)
        finally:
            os._exit(0)
    try:
        for k in range(0, count, 2):
            _fill(rows, row, k)
        os.waitpid(child, 0)
        child = 0
    finally:
        if child:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
    for k in np.flatnonzero(rows[:, -1] == 0.0):
        _fill(rows, row, int(k))
    return rows[:, :-1].copy()


def _fill(rows: Floats, row: Callable[[int], Floats], k: int) -> None:
    """Enter one row, and behind it that it is there."""
    rows[k, :-1] = row(k)
    rows[k, -1] = 1.0
