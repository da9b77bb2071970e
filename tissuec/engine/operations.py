"""Operations on nets: their parts, and which compiled ones a scene needs."""

from collections.abc import Callable
from functools import cache
from itertools import compress
from typing import Any

from msgspec import Struct

from tissuec.compiled.bundles import FLAGS
from tissuec.compiled.calls import NetOperation
from tissuec.engine.integrators.banded import assemble, solve
from tissuec.forces.accelerations import (
    force,
    greatest_force,
    greatest_inner_force,
    kinetic,
    place,
)
from tissuec.forces.springs.springs_kernel import (
    bend_of_passed,
    find_sides,
    peaks,
    slack,
    springs,
    tension,
)
from tissuec.kernels.records import Operations
from tissuec.laws import LINEAR, Law, code

#: What the members of ``Operations`` are made from, but for laws. Some have other forms, too.
FUNCTIONS: dict[str, Callable[..., Any]] = {
    function.__name__: function
    for function in (
        assemble, bend_of_passed, find_sides, force, greatest_force, greatest_inner_force,
        kinetic, peaks, place, slack, solve, springs, tension,
    )
}  # fmt: skip
#: The compiled ones, which take a net that has their addresses.
OPERATIONS = {name: NetOperation(function) for name, function in FUNCTIONS.items()}
# Operations on nets that only some scenes need.
NEEDED = {
    "bend_of_passed": "cornered",
    "find_sides": "cornered",
    "kinetic": "ledger",
    "peaks": "watched",
    "tension": "watched",
}
LAWS = tuple(code.ARGUMENTS)


class Features(Struct, frozen=True):
    """Features that a scene needs; a kernel is compiled without the others."""

    viscous: bool
    watched: bool
    crushed: bool
    ledger: bool
    banded: bool = False
    reeled: bool = False
    touched: bool = False
    inelastic: bool = False
    cornered: bool = False
    embedded: bool = False
    guided: bool = False
    laws: tuple[Law, ...] = ()  # the linear one and others, if there are others
    in_runs: bool = False  # springs lie in runs

    @property
    def straight(self) -> bool:
        """Return whether all springs are linear and forget everything."""
        return not (self.laws or self.inelastic)


@cache
def operations(names: frozenset[str], features: Features) -> Operations:
    """Return where some compiled operations are, and those that they call, for a scene."""
    names |= {"springs"}
    needed = {name for name in names if name not in NEEDED or getattr(features, NEEDED[name])}
    if not features.straight:
        needed |= set(LAWS)
    return Operations(**{name: _operation(name, features) for name in sorted(needed)})


def _operation(name: str, features: Features) -> int:
    """Return the address of an operation on nets, compiled for what a scene needs."""
    from tissuec.compiled.bundles import BUNDLE_OF
    from tissuec.compiled.loading import address

    if name in LAWS:
        from tissuec.compiled import laws

        return laws.address(name, features.laws or (LINEAR,))
    if name == "springs":
        name = _form_of_springs(features)
    elif name in ("assemble", "solve"):
        name += "_banded" if features.banded else "_iterative"
    return address(BUNDLE_OF[name], name)


def _form_of_springs(features: Features) -> str:
    """Return which form of the forces of springs a scene needs."""
    name = "springs_in_runs" if features.in_runs else "springs"
    of_laws = not features.straight  # all of them have one form
    has = features.viscous or of_laws, features.watched or of_laws, of_laws
    return name + "".join(f"_{flag.lower()}" for flag in compress(FLAGS, has))
