"""What is found once for elements that are alike is what all of them have."""

import numpy as np
import pytest

import tissuec
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.core.structs import replace
from tissuec.forces import element_fields, point_fields
from tissuec.forces.matrices import without_negative
from tissuec.laws.formula import Variable, exp
from tissuec.laws.uniaxial import OfTension

LATTICE = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }
body block {
  mesh is lattice { cell = 4 mm; box from (0, 0, 0) mm to (20, 20, 20) mm }; tissue is gel
}
set base = nodes of block where z < 0.01 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix base }
simulate { duration = 1 ms }
output { force(base) every 1 ms }
"""


def lattice():
    state = state_at_start(tissuec.compile(LATTICE))
    (field,) = state.elements
    return field, state.position


@pytest.mark.parametrize("move", ["as drawn", "moved", "one node displaced"])
def test_their_operator_is_the_matrix_of_all(move, monkeypatch):
    monkeypatch.setattr(element_fields, "MANY", 1)
    field, position = lattice()
    position = position.copy()
    if move == "moved":
        position += (0.3, -0.2, 0.1)  # [m], which changes rounding
    elif move == "one node displaced":
        inner = np.bincount(field.nodes.ravel()).argmax()
        position[inner] += 1e-4
    first, like = field.alike(position)
    assert len(first) == (9 if move == "one node displaced" else 1)
    assert np.array_equal(like[first], np.arange(len(first)))
    size = len(position)
    vector, found = (
        np.sin(1.0 + np.arange(3.0 * size) ** 2).reshape(size, 3),
        np.zeros((size, 3)),
    )
    field.stiffening(0.0, position)(vector, found)
    matrix = field.matrix(0.0, position, np.arange(size), size, exact=False)
    expected = (matrix @ vector.ravel()).reshape(size, 3)
    # Alike are places that agree to 1e-9 of a cell.
    assert np.abs(found - expected).max() <= 1e-7 * np.abs(expected).max()


def test_elements_of_other_tissue_are_not_alike():
    field, position = lattice()
    stiff = field.shear.copy()
    stiff[field.item_count // 2 :] *= 5.0
    first, like = replace(field, shear=stiff).alike(position)
    assert len(first) == 2
    assert np.array_equal(like == like[0], stiff == stiff[0])


@pytest.mark.parametrize("wrong", [0, 1, 40])
def test_only_what_is_indefinite_is_clamped(wrong):
    draw = np.random.default_rng(2)
    half = draw.normal(size=(40, 9, 6))  # of rank 6, as of elements with rigid motions
    matrices = half @ half.swapaxes(1, 2)
    chosen = draw.permutation(len(matrices))[:wrong]
    matrices[chosen] -= 2.0 * np.eye(9)
    value, way = np.linalg.eigh(matrices)
    expected = (way * np.maximum(value, 0.0)[:, None, :]) @ way.swapaxes(1, 2)
    found = without_negative(matrices.reshape(5, 8, 9, 9)).reshape(-1, 9, 9)
    stays = np.setdiff1d(np.arange(40), chosen)
    assert np.array_equal(found[stays], matrices[stays])
    # A part of 1e-11 of the largest entry counts as none.
    assert np.abs(found - expected).max() <= 1e-10 * np.abs(matrices).max()


def test_matrices_of_places_without_an_energy_are_left_alone():
    """Exponential laws overflow far away, where Newton's method does not stay."""
    matrices = np.array([np.diag([1.0, -1.0]), np.full((2, 2), np.nan), np.eye(2)])
    found = without_negative(matrices)
    assert np.array_equal(found[::2], [np.diag([1.0, 0.0]), np.eye(2)])
    assert np.isnan(found[1]).all()


def test_energies_of_many_elements_of_a_curve_are_those_of_a_few(monkeypatch):
    """No kernel can find them."""
    field, drawn = lattice()
    strain = Variable("strain")
    field = replace(field, laws=(OfTension(5e3 / 3.0 * (exp(3.0 * strain) - 1.0), 5e3),))
    position = drawn + 1e-4 * np.sin(np.arange(drawn.size) ** 2).reshape(drawn.shape)
    few = field.energies(position)
    monkeypatch.setattr(point_fields, "MANY", 1)
    # Divided by volumes and multiplied again.
    np.testing.assert_allclose(field.energies(position), few, rtol=1e-15)


@pytest.mark.parametrize("size", [0.0, 1e-4, 3e-3])
def test_energies_of_many_elements_are_those_of_a_few(size, monkeypatch):
    """A kernel finds them, instead of NumPy, also inside out."""
    field, drawn = lattice()
    position = drawn + size * np.sin(np.arange(drawn.size) ** 2).reshape(drawn.shape)
    few = field.energies(position)
    monkeypatch.setattr(point_fields, "MANY", 1)
    # Both round stretches, whose energies are of moduli times volumes.
    rounding = 1e-14 * (field.shear + field.bulk) * field.volume
    assert (np.abs(field.energies(position) - few) <= 1e-12 * np.abs(few) + rounding).all()
