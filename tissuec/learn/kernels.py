"""The functions of ``kernels.sensitivity`` and ``explicit``, compiled, with laws of a net."""

from collections.abc import Callable
from functools import cache, partial
from typing import Any

from tissuec.compiled.calls import Shipped
from tissuec.compiled.formulas import partial_address
from tissuec.compiled.tables import RecordTable
from tissuec.kernels import explicit, sensitivity
from tissuec.laws import Law
from tissuec.laws.partial import ARGUMENTS


class Kernels:
    """What both modules have, under the same names.

    Changes over steps are functions of the first and the last row, once the rest is given.

    Args:
        laws: The first is the linear one.
        constants: How many of their constants may change.
    """

    def __init__(self, laws: tuple[Law, ...], constants: int):
        curved = len(laws) > 1
        places = {name: partial_address(name, laws, constants) for name in ARGUMENTS if curved}
        table = RecordTable(sensitivity.Laws(curved, **places))

        def bound(function: Callable[..., None]) -> Callable[..., None]:
            return partial(_shipped(function), table)

        def by_rows(function: Callable[..., None]) -> Callable[..., Callable[[int, int], None]]:
            return partial(_shipped(function).of_first, table)

        self.acceleration = bound(sensitivity.acceleration)
        self.pull_back = bound(sensitivity.pull_back)
        self.push_forward = bound(sensitivity.push_forward)
        self.verlet_forward = bound(sensitivity.verlet_forward)
        self.verlet_back = bound(sensitivity.verlet_back)
        self.verlet_change = by_rows(sensitivity.verlet_change)
        self.explicit_forward = bound(explicit.explicit_forward)
        self.explicit_back = bound(explicit.explicit_back)
        self.explicit_change = by_rows(explicit.explicit_change)


@cache
def _shipped(function: Callable[..., Any]) -> Shipped:
    return Shipped(function, "derivatives")
