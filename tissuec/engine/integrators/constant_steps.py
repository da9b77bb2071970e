"""Sizes of steps of symplectic methods, which stay as they are for long.

A constant size keeps a method symplectic. At the start the size doubles with every step, until
the error is near to what is allowed; later it grows only if all of several steps allow it.
"""

CONTROL_ORDER = 2.0  # of a member; bound to its own
# Steps of a size before it may grow; with 8, growing errors may exceed the tolerance.
AFTER_CHANGE = 16
AFTER_REJECTION = 32  # the same after a step that was rejected


def propose(h: float, ratio: float, memory: float, wait: int) -> tuple[float, float, int]:
    """Return the next step; ``memory`` is the largest ratio since the last change."""
    worst = max(ratio, memory)
    if wait > 0:
        return h, worst, wait - 1
    growth = (0.6 / max(worst, 1e-3)) ** (1.0 / CONTROL_ORDER)
    if growth > 2.0:
        return 2.0 * h, 0.0, 0
    return (h * growth if worst < 0.25 else h), 0.0, AFTER_CHANGE
