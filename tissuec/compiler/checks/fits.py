"""Check of what learn blocks adjust."""

from collections.abc import Iterator

import numpy as np

from tissuec.compiler.checks import check
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import Diagnostic
from tissuec.core.units import show

_ROUNDING = 1e-9  # of a value, by which a mean may differ from the limit that it is written as


@check
def starts_outside_limits(compiled: Compiled) -> Iterator[Diagnostic]:
    """W802: an adjusted value begins outside the limits of its entry."""
    adjusts = [adjust for problem in compiled.fit_problems for adjust in problem.adjusts]
    if not adjusts:
        return
    from tissuec.compiler.learning.starts import start_of  # where something is adjusted

    for adjust in adjusts:
        start = start_of(adjust, compiled)
        slack = _ROUNDING * np.abs(start)
        outside = (start < adjust.low - slack) | (start > adjust.high + slack)
        if not outside.any():
            continue
        value = float(start[outside.argmax()])
        limit, side = (adjust.low, "below") if value < adjust.low else (adjust.high, "above")
        shown = show(value, adjust.dimension)
        yield Diagnostic(
            "W802",
            f"{adjust.what} of {adjust.of} starts at {shown}, {side} its limit "
            f"{show(limit, adjust.dimension)}, where the fit starts instead",
            adjust.span,
            f"write limits that contain {shown}, or another initial value",
        )
