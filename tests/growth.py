"""How effort grows with what is long, whatever the speed of the computer."""

import gc
import sys
from collections.abc import Callable
from time import process_time

LONGER = 8
MOST = 24.0  # times the effort for what is LONGER times as long; its square would take 64 times
NOTHING = 0.02  # of the processor's time [s]: less is not told from chance
ATTEMPTS = 5  # other programs only add to the time, so that the least ones are compared
FEW = 1.5  # times LONGER: most calls for what is LONGER times as long


def effort(work: Callable[[], object]) -> float:
    """Return the processor's time that work takes [s].

    Garbage collection during the work passes over the objects that other tests left.
    """
    gc.freeze()
    begin = process_time()
    work()
    return process_time() - begin


def calls(work: Callable[[], object]) -> int:
    """Return how many functions work calls, of Python and of C, at whatever speed."""
    count = 0

    def look(_frame: object, event: str, _argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(look)
    try:
        work()
    finally:
        sys.setprofile(before)
    return count


def grows_in_proportion(work: Callable[[int], Callable[[], object]], length: int) -> bool:
    """Tell whether effort grows as a length does, and not as its square.

    Args:
        work: Makes what is timed, of a length.
        length: The greater one.
    """
    work(LONGER)()  # imports and caches
    long, short = work(length), work(length // LONGER)
    taken = brief = float("inf")
    for _ in range(ATTEMPTS):
        taken, brief = min(taken, effort(long)), min(brief, effort(short))
        if taken < NOTHING or taken < MOST * brief:
            return True
    return False


def calls_grow_in_proportion(work: Callable[[int], Callable[[], object]], length: int) -> bool:
    """Tell whether the number of calls grows as a length does, whatever else is running.

    Args:
        work: Makes what is counted, of a length.
        length: The greater one.
    """
    work(LONGER)()  # imports and caches
    return calls(work(length)) < FEW * LONGER * calls(work(length // LONGER))
