"""Forces and matrices of solid elements are those of felupe, to rounding.

Hexahedra are of a kind of their own, which has the same forces where strain is even, on any
mesh. Tetrahedra with ten nodes have no mean volume in felupe; nor have those of tissuec where
the bulk modulus is less than twice the shear modulus.
"""

import felupe
import numpy as np
import pytest

from tests.derivatives import forces
from tests.forces.test_elements import SPAN, deformed, mesh
from tissuec.forces.solids.bent_elements import kind_of
from tissuec.forces.solids.elements import SolidMaterial
from tissuec.geometry.elements import SHAPES
from tissuec.laws.solid.invariants import NeoHookean

KINDS = {
    "hexahedron": ("hexahedron", felupe.RegionHexahedron),
    "tetrahedron": ("tetra10", felupe.RegionQuadraticTetra),
}


@pytest.mark.parametrize(("name", "poisson"), [
    ("hexahedron", 0.0), ("hexahedron", 0.3), ("hexahedron", 0.4999), ("tetrahedron", 0.2),
])  # fmt: skip
@pytest.mark.parametrize("size", [1e-6, 1.0], ids=["micrometres", "metres"])
def test_forces_and_matrices_are_those_of_felupe(name, poisson, size):
    drawn, nodes = mesh(name)
    count, young = len(nodes), 3e3
    shear, bulk = young / 2.0 / (1.0 + poisson), young / 3.0 / (1.0 - 2.0 * poisson)
    material = SolidMaterial(
        np.full(count, shear), np.full(count, bulk), np.zeros(count), np.zeros(count, int),
        (NeoHookean(volume="quadratic"),),
    )  # fmt: skip
    is_even = name == "hexahedron"
    position = size * deformed(drawn, 0.0 if is_even else 5e-4)
    drawn = size * drawn
    own = kind_of(SHAPES[name]).of("cube", SHAPES[name], nodes, drawn, material, 0, SPAN)

    kind, region = KINDS[name]
    field = felupe.Field(region(felupe.Mesh(drawn, nodes, kind)), dim=3)
    field.values[:] = position - drawn
    container = felupe.FieldContainer([field])
    other = felupe.SolidBody(felupe.NeoHooke(mu=shear, bulk=bulk), container)
    # Places of the points of its tetrahedra have eight digits.
    exact = 1e-11 if is_even else 1e-7
    expected = -other.assemble.vector(container).toarray().reshape(-1, 3)
    np.testing.assert_allclose(
        forces(own, position), expected, atol=exact * np.abs(expected).max()
    )
    if is_even:
        return  # matrices differ where nodes move unevenly
    matrix = own.matrix(0.0, position, np.arange(len(drawn)), len(drawn)).toarray()
    due = other.assemble.matrix(container).toarray()
    np.testing.assert_allclose(matrix, due, atol=10.0 * exact * np.abs(due).max())
