"""Functions that tests have workers do."""

import os
import signal
import threading
import time
from pathlib import Path


def doubled(common, item):
    """Return twice the item, plus what is common."""
    return common + 2 * item


def process_id(common, item):
    """Return which process this is, after so many seconds."""
    time.sleep(item)
    return os.getpid()


def killing(folder: Path, item: int):
    """Kill this process: at item 3 whenever it comes, at item 5 for the first time only."""
    mark = folder / "killed once"
    if item == 3 or (item == 5 and not mark.exists()):
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return item


def raising(common, item):
    """Raise what a program of somebody else might."""
    raise KeyError(item)


class Unpicklable(Exception):
    """An exception that no pipe takes."""

    def __init__(self, text: str, lock: object):
        super().__init__(text)
        self.lock = lock


def raising_oddly(common, item):
    """Raise something that cannot be pickled."""
    raise Unpicklable("odd", threading.Lock())


def busy(common, item):
    """Sleep for a long time, deaf to polite signals as a run is."""
    Path(common, str(os.getpid())).touch()
    time.sleep(60.0)
