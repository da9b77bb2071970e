"""The functions of ``kernels.sensitivity`` and ``explicit``, bound to laws and compiled."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cache
from typing import Any

from tissuec.engine.binding import Binder
from tissuec.engine.tiers import forced_tier
from tissuec.kernels import explicit, sensitivity
from tissuec.laws import Law
from tissuec.laws.partial import functions


@dataclass(frozen=True, slots=True)
class Kernels:
    """What both modules have, under the same names."""

    acceleration: Callable[..., Any]
    pull_back: Callable[..., Any]
    push_forward: Callable[..., Any]
    verlet_forward: Callable[..., Any]
    verlet_back: Callable[..., Any]
    verlet_change: Callable[..., Any]
    explicit_stages: Callable[..., Any]
    explicit_forward: Callable[..., Any]
    explicit_back: Callable[..., Any]
    explicit_change: Callable[..., Any]


OPERATIONS = tuple(entry.name for entry in fields(Kernels))


def kernels(laws: tuple[Law, ...], constants: int, *, compiled: bool | None = None) -> Kernels:
    """Return the functions for the laws of a net.

    Args:
        laws: The first is the linear one.
        constants: How many of their constants may change.
        compiled: Whether Numba compiles them; otherwise they are plain Python, for tests.
            None compiles them unless the environment variable TISSUEC_TIER asks for
            "interpreted".
    """
    if compiled is None:
        compiled = forced_tier() != "interpreted"
    return _bound(laws, constants, compiled)


@cache
def _bound(laws: tuple[Law, ...], constants: int, compiled: bool) -> Kernels:
    replaced: dict[str, Any] = dict(functions(laws, constants))
    replaced["CURVED"] = len(laws) > 1
    binder = Binder(replaced, compiled=compiled)
    both = vars(sensitivity) | vars(explicit)
    return Kernels(**{name: binder.bind(both[name]) for name in OPERATIONS})
