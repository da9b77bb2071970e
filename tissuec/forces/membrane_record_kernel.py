"""Triangles of walls as kernels read them."""

from typing import NamedTuple

from tissuec.kernels.records import Floats, IntegerRows, Integers, Rows, Stack

STATE = 17  # numbers of the state of a triangle


class MembraneTable(NamedTuple):
    """Membranes as the kernel reads them."""

    nodes: IntegerRows  # shape (triangle, 3)
    gradients: Rows  # ∂N/∂X by node and direction in the plane [1/m], shape (triangle, 6)
    weight: Floats  # volume [m³], shape (triangle,)
    shear: Floats  # [Pa], shape (triangle,)
    bulk: Floats  # [Pa], shape (triangle,)
    viscosity: Floats  # [Pa s], shape (triangle,)
    thinning: Floats  # rate of strain across the plane per rate of area, shape (triangle,)
    law: Integers  # shape (triangle,)
    fibres: Stack  # unit vectors in the plane as drawn, shape (triangle, family, 2)
    fibre_stiffness: Floats  # k1 [Pa], shape (triangle,)
    fibre_stiffening: Floats  # k2, shape (triangle,)
    dispersion: Floats  # κ, shape (triangle,)
    first: Integers  # branches of triangle e are first[e]:first[e + 1], shape (triangle + 1,)
    branch_shear: Floats  # μk [Pa], shape (branch,)
    branch_pace: Floats  # 1 / τ [1/s], shape (branch,)
    branch_slot: Integers  # where the first number of a branch is among velocities, (branch,)
    branch_rate: Floats  # of P - 1 in these [m/s], shape (branch,)
    yield_slot: Integers  # where the first number of Pp is; -1 in triangles that do not yield
    yield_rate: Floats  # of Pp - 1 there [m/s], shape (triangle,); empty if none yields
    yield_stress: Floats  # Y [Pa], likewise
    yield_pace: Floats  # 1 / η [1/(Pa s)], likewise
    is_curved: bool  # whether any law is not neo-Hookean
    is_viscous: bool
    by_first: int  # addresses of derivatives of laws by the invariants
    by_second: int
    by_first_twice: int
    by_both: int
    by_second_twice: int
    state: Floats  # scratch, see ``measure`` and ``remember``, shape (STATE,)
