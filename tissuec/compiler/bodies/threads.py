"""Threads: springs that form knots, and contact of threads.

A network has all its springs from the start. So a thread is compiled with a spring between its
ends that a knot holds by, and with one beside it that pulls with a constant force while the
knot slips; both wait until they are needed. A loop has the first one as its last piece.
"""

from collections.abc import Container, Sequence

import numpy as np
from numpy.typing import NDArray

from tissuec.core.structs import replace
from tissuec.laws import LINEAR, VISCOSITY_LAWS, D, Law
from tissuec.meshes.generators import Mesh, Threaded
from tissuec.model.inelastic import TIMES, VISCOSITY
from tissuec.model.network import Floats, Indices, Network, ThreadBody

SLIPPING = Law("slipping knot", LINEAR.elastic, D)
"""A spring of no stiffness whose dashpot pulls with the force d, however fast it is."""


def knot_pairs(mesh: Mesh, generator: Threaded) -> NDArray[np.int32]:
    """Return the ends of the springs that a thread needs for its knot, shape (1 or 2, 2)."""
    count = 1 if generator.is_loop() else 2
    return np.tile(np.array([[0, len(mesh.position) - 1]], dtype=np.int32), (count, 1))


def thread_of(generator: object, ends: NDArray[np.int32]) -> ThreadBody | None:
    """Return the thread of a body, numbered within it; None if the body is no thread.

    Args:
        ends: Of its springs with those of the knot, shape (spring, 2).
    """
    if not isinstance(generator, Threaded):
        return None
    last = int(ends.max())
    across = np.flatnonzero((ends == (0, last)).all(axis=1))
    hold, slip = (int(spring) for spring in across[-2:])
    pieces = slice(0, slip if generator.is_loop() else hold)
    return ThreadBody(pieces, hold, slip, generator.thread_radius(), generator.is_loop())


def renumbered(thread: ThreadBody | None, by: int) -> ThreadBody | None:
    """Return a thread with other numbers of springs."""
    if thread is None:
        return None
    pieces = slice(thread.pieces.start + by, thread.pieces.stop + by)
    return ThreadBody(pieces, thread.hold + by, thread.slip + by, thread.radius, thread.closed)


def with_slipping(
    arrays: dict[str, Floats], law: NDArray[np.int32], laws: tuple[Law, ...], thread: ThreadBody
) -> tuple[dict[str, Floats], NDArray[np.int32], tuple[Law, ...]]:
    """Return arrays, laws of springs and all laws of a body, with its knot.

    Args:
        arrays: Numbers of springs by name in SI units, shape (spring,).
        law: Index of the law of each spring, shape (spring,).
        laws: All laws.
    """
    hold, slip, law = thread.hold, thread.slip, law.copy()
    changed = {name: values.copy() for name, values in arrays.items()}
    for name in ("stiffness", "damping"):
        changed[name][slip] = 0.0
    for name in ("strength", "crush"):
        changed[name][slip] = np.inf
    for name in changed.keys() & {*TIMES, VISCOSITY}:  # knots neither relax nor yield
        changed[name][[hold, slip]] = np.inf
    own = laws[int(law[hold])]
    if own.viscous != LINEAR.viscous:  # which cannot be switched off when it is tied
        changed["damping"][hold], law[hold] = 0.0, len(laws)
        linear = VISCOSITY_LAWS["linear"]()
        laws = (*laws, replace(own, viscous=LINEAR.viscous, dashpot=linear))
    law[slip] = len(laws)
    return changed, law, (*laws, SLIPPING)


def idle_knots(network: Network, tied: Container[str]) -> Indices:
    """Return the springs of threads that no log shows, shape (spring,).

    Knots that are never tied, and the springs beside knots: a log of a knot has their tension.

    Args:
        tied: Names of the threads that are tied.
    """
    threads = network.threads.items()
    slips = [thread.slip for _, thread in threads]
    knots = [one.hold for name, one in threads if not one.closed and name not in tied]
    return np.array([*slips, *knots], dtype=np.int64)


def bonds(thread: ThreadBody) -> Sequence[tuple[int, tuple[int, int]]]:
    """Return each piece of a thread and the springs of which one must be there, -1 for none."""
    pieces = range(thread.pieces.start, thread.pieces.stop)
    along = [(spring, (spring, -1)) for spring in pieces if spring != thread.hold]
    return [*along, (thread.hold, (thread.hold, thread.slip))]
