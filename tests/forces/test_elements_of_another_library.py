"""Forces and matrices of solid elements are those of felupe, to rounding.

Its hexahedra have a mean volume, too; they are given gradients that deviate less from their
mean. Its tetrahedra with ten nodes have no mean volume; nor have those of tissuec where the
bulk modulus is less than twice the shear modulus.
"""

import felupe
import numpy as np
import pytest

from tests.derivatives import forces
from tests.forces.test_elements import SPAN, deformed, mesh
from tissuec.forces.solids.elements import SolidElements, SolidMaterial
from tissuec.geometry.elements import SHAPES
from tissuec.laws.solid.invariants import NeoHookean

KINDS = {
    "hexahedron": ("hexahedron", felupe.RegionHexahedron, felupe.SolidBodyNearlyIncompressible),
    "tetrahedron": ("tetra10", felupe.RegionQuadraticTetra, felupe.SolidBody),
}


def drawn_together(region):
    """Make what gradients of a region differ by from their means smaller, by √(3/4)."""
    mean = (region.dhdX * region.dV).sum(axis=2) / region.dV.sum(axis=0)
    region.dhdX[:] = mean[:, :, None] + np.sqrt(0.75) * (region.dhdX - mean[:, :, None])
    return region


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
        (NeoHookean(),),
    )  # fmt: skip
    none = np.zeros((0, 2), dtype=np.int32)
    position = size * deformed(drawn, 5e-4)
    drawn = size * drawn
    own = SolidElements.of("cube", SHAPES[name], nodes, drawn, material, none, 0, SPAN)

    kind, region, body = KINDS[name]
    made = region(felupe.Mesh(drawn, nodes, kind))
    field = felupe.Field(drawn_together(made) if name == "hexahedron" else made, dim=3)
    field.values[:] = position - drawn
    container = felupe.FieldContainer([field])
    if name == "hexahedron":
        local = 0.375 * shear
        other = body(felupe.NeoHooke(mu=shear, bulk=local), container, bulk=bulk - local)
    else:
        other = body(felupe.NeoHooke(mu=shear, bulk=bulk), container)
    # The first evaluation sets the pressures of the library's elements.
    other.assemble.vector(container)
    # Places of the points of its tetrahedra have eight digits.
    exact = 1e-11 if name == "hexahedron" else 1e-7
    expected = -other.assemble.vector(container).toarray().reshape(-1, 3)
    np.testing.assert_allclose(
        forces(own, position), expected, atol=exact * np.abs(expected).max()
    )
    matrix = own.matrix(0.0, position, np.arange(len(drawn)), len(drawn)).toarray()
    due = other.assemble.matrix(container).toarray()
    np.testing.assert_allclose(matrix, due, atol=10.0 * exact * np.abs(due).max())
