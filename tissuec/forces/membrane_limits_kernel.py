"""How near triangles of walls are to breaking, as loops; see ``forces.element_limits``."""

from math import sqrt
from typing import NamedTuple

from tissuec.forces.element_limits_kernel import NONE, grown
from tissuec.forces.elements_kernel import call_law
from tissuec.forces.membranes_kernel import (
    MembraneTable,
    fibre_strain,
    measure,
    stress,
    volume_root,
)
from tissuec.kernels.records import Floats


class MembraneLimitTable(NamedTuple):
    """Triangles that can break as the kernel reads them; a limit that one lacks is infinite."""

    strain: Floats  # shape (triangle,)
    stress: Floats  # [Pa], shape (triangle,)
    energy: Floats  # [J], shape (triangle,)
    energies: int  # address of the energies of laws; 0 where no energy breaks triangles
    wall: MembraneTable


def burden_membranes(
    time: float, x: Floats, v: Floats, f: Floats, power: Floats, limits: MembraneLimitTable
) -> None:
    """Set the load of each triangle, divided by its limit.

    Args:
        f: Set, dimensionless, shape (triangle,).
        limits: The triangles.
    """
    wall = limits.wall
    state = wall.state
    for e in range(wall.nodes.shape[0]):
        i, j, k = 3 * wall.nodes[e, 0], 3 * wall.nodes[e, 1], 3 * wall.nodes[e, 2]
        n0, n1, n2 = wall.gradients[e, 0], wall.gradients[e, 2], wall.gradients[e, 4]
        m0, m1, m2 = wall.gradients[e, 1], wall.gradients[e, 3], wall.gradients[e, 5]
        # The columns of F, and C.
        first = mixed = second = 0.0
        for c in range(3):
            a = x[i + c] * n0 + x[j + c] * n1 + x[k + c] * n2
            b = x[i + c] * m0 + x[j + c] * m1 + x[k + c] * m2
            first, mixed, second = first + a * a, mixed + a * b, second + b * b
        widest = sqrt(larger(first, mixed, mixed, second))
        f[e] = (widest - 1.0) / limits.strain[e]
        if limits.stress[e] < NONE or limits.energy[e] < NONE:
            measure(first, mixed, second, state)
            root = volume_root(e, wall)
            s, t, u = stress(e, root, wall)
            # S C has the principal values of F S Fᵀ.
            pull = larger(
                s * first + t * mixed, s * mixed + t * second,
                t * first + u * mixed, t * mixed + u * second,
            )  # fmt: skip
            f[e] = max(f[e], pull / widest / limits.stress[e])
            if limits.energy[e] < NONE:
                stored = wall.weight[e] * stored_in(e, root, limits)
                f[e] = max(f[e], stored / limits.energy[e])


def larger(a: float, b: float, c: float, d: float) -> float:
    """Return the larger eigenvalue of a matrix that has real ones.

    Args:
        a, b: Its first row, in any unit.
        c, d: Its second row.
    """
    half = 0.5 * (a - d)
    return 0.5 * (a + d) + sqrt(max(half * half + b * c, 0.0))


def stored_in(e: int, root: float, limits: MembraneLimitTable) -> float:
    """Return the energy of a triangle per volume [J/m³].

    Args:
        e: Its number.
        root: The cube root of J.
        limits: The triangles.
    """
    wall = limits.wall
    state = wall.state
    trace, square, over = state[3], state[4], root * root / state[5]
    g, outside = 1.0 / (root * root), over * over
    i1 = g * trace + outside
    if wall.is_curved and wall.law[e] > 0:
        i2 = g * (g * square + outside * trace)
        stored = wall.shear[e] * call_law(limits.energies, wall.law[e], i1, i2)
    else:
        stored = 0.5 * wall.shear[e] * (i1 - 3.0)
    j = root * root * root
    stored += 0.5 * wall.bulk[e] * (j - 1.0) * (j - 1.0)
    for family in range(wall.fibres.shape[1]):
        strain = fibre_strain(e, family, i1, wall)
        if strain > 0.0:
            steep = wall.fibre_stiffening[e]
            more = grown(steep * strain * strain)
            stored += 0.5 * wall.fibre_stiffness[e] / steep * more
    return float(stored)
