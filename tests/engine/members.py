"""Which integrators a law is about, by what they declare: a new file is tested by itself."""

import pytest

from tissuec.engine.integrators import INTEGRATORS

# What promises nothing is offered for fidelity, and has tests of its own.
MEMBERS = sorted(name for name in INTEGRATORS if INTEGRATORS[name].promises)

# Members on the backend that users get; and one interpreted, as methods of users are.
ON_BACKENDS = [
    *(pytest.param(name, None, id=name) for name in MEMBERS),
    pytest.param("dop853", "interpreted", id="dop853-interpreted"),
]


def those(**declared):
    """Return the names of the members with these declared properties."""
    return [
        name
        for name in MEMBERS
        if all(getattr(INTEGRATORS[name], key) == value for key, value in declared.items())
    ]


def affordable(name):
    """Return a tolerance that a member keeps with a few thousand steps of small nets."""
    order = INTEGRATORS[name].order
    return 1e-4 if order < 4 else 1e-7 if order <= 4 else 1e-9


def order_under(name, damping):
    """Return the order that a member declares for nets with a viscosity, or without one."""
    member = INTEGRATORS[name]
    return getattr(member, "order_with_dashpots", member.order) if damping else member.order


def brakes(name, damping):
    """Return a damping, or none for members that are only for scenes without it."""
    return 0.0 if INTEGRATORS[name].conservative else damping


def viscosities(*values):
    """Return pairs of member and viscosity, of which conservative members get none but zero."""
    return [(name, d) for name in MEMBERS for d in values if brakes(name, d) == d]
