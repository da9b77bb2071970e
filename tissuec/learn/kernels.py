"""The functions of ``kernels.sensitivity``, bound to the laws of a net and compiled."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

from tissuec.engine.binding import Binder
from tissuec.kernels import sensitivity
from tissuec.laws import Law
from tissuec.laws.partial import functions

OPERATIONS = (
    "acceleration",
    "pull_back",
    "push_forward",
    "verlet_forward",
    "verlet_back",
    "verlet_change",
)


@dataclass(frozen=True, slots=True)
class Kernels:
    """What ``kernels.sensitivity`` has, under the same names."""

    acceleration: Callable[..., Any]
    pull_back: Callable[..., Any]
    push_forward: Callable[..., Any]
    verlet_forward: Callable[..., Any]
    verlet_back: Callable[..., Any]
    verlet_change: Callable[..., Any]


@cache
def kernels(laws: tuple[Law, ...], constants: int, *, compiled: bool = True) -> Kernels:
    """Return the functions for the laws of a net.

    Args:
        laws: The first is the linear one.
        constants: How many of their constants may change.
        compiled: Whether Numba compiles them; otherwise they are plain Python, for tests.
    """
    replaced: dict[str, Any] = dict(functions(laws, constants))
    replaced["CURVED"] = len(laws) > 1
    binder = Binder(replaced, OPERATIONS if compiled else ())
    return Kernels(**{name: binder.bind(getattr(sensitivity, name)) for name in OPERATIONS})
