"""Elements that are stretched as drawn: closed forms, energies, formulas of the reference."""

import numpy as np
import pytest

from tests.derivatives import agree, forces, slopes, stiffness
from tests.forces.test_elements import (
    BULK,
    SHEAR,
    SPAN,
    deformed,
    fibres_of,
    mesh,
    with_flat_sides,
)
from tests.validate.scenes import compiled_scene
from tests.whole_runs import carried_out
from tissuec.compiled.loops.tables import LANES
from tissuec.forces.solids.bent_elements import kind_of
from tissuec.forces.solids.elements import SolidMaterial
from tissuec.forces.solids.solid_strain import Prestretch, SolidFibres
from tissuec.geometry.elements import SHAPES
from tissuec.laws.solid.invariants import MooneyRivlin, NeoHookean
from tissuec.validate.forces.elements import ElementSolid

AXIS = np.array([0.48, 0.6, 0.64])


def solid(name, law, prestretch, *, fibres=None, viscosity=0.0, displaced=0.15, cells=2):
    """Return elements of one material in a cube of 20 mm, and where their nodes are drawn."""
    position, nodes = mesh(name, cells=cells, displaced=displaced)
    if name == "wedge":
        position = with_flat_sides(position)
    count = len(nodes)
    moduli = (np.full(count, each) for each in (SHEAR, BULK, viscosity))
    axis, is_across, stretch = prestretch
    stretched = Prestretch(axis, is_across, np.broadcast_to(stretch, (count,)))
    material = SolidMaterial(
        *moduli, np.zeros(count, dtype=np.int64), (law,), fibres and fibres(count), stretched
    )
    made = kind_of(SHAPES[name]).of("skin", SHAPES[name], nodes, position, material, 0, SPAN)
    return made, position


def uneven(count):
    """Return two stretches in turns, 1 and another one."""
    return 1.0 + 0.2 * (np.arange(count) % 2)


@pytest.mark.parametrize("is_across", [False, True], ids=["along", "across"])
@pytest.mark.parametrize("name", SHAPES)
def test_forces_follow_from_the_energy_and_agree_with_the_reference(name, is_across):
    count = len(mesh(name)[1])
    made, drawn = solid(
        name, MooneyRivlin(0.3), (AXIS, is_across, uneven(count)), fibres=fibres_of,
        viscosity=1.5,
    )  # fmt: skip
    reference = ElementSolid(made, drawn)
    position, count = deformed(drawn, 5e-4), len(drawn)
    velocity = np.random.default_rng(2).normal(size=position.shape)
    agree(
        made, reference, position, velocity, force=1e-11, matrix=1e-11, energy=1e-11, lost=1e-12
    )
    by_energy = slopes(lambda x: made.energy(0.0, x), position, range(4), 1e-8)
    still = forces(made, position)
    np.testing.assert_allclose(still[:4], by_energy, atol=2e-6 * np.abs(still).max())
    matrix = made.matrix(0.0, position, np.arange(count), count).toarray()
    np.testing.assert_allclose(
        matrix[:, 5], stiffness(made, position, 5, 1e-9),
        atol=3e-6 * np.abs(matrix).max(),
    )  # fmt: skip


def deviator(b):
    return b - np.trace(b) / 3.0 * np.eye(3)


@pytest.mark.parametrize("is_across", [False, True], ids=["along", "across"])
@pytest.mark.parametrize("name", SHAPES)
def test_a_block_held_as_drawn_has_the_stress_of_its_prestretch(name, is_across):
    made, drawn = solid(name, NeoHookean(), (AXIS, is_across, 1.2), displaced=0.25, cells=3)
    line = np.outer(AXIS, AXIS)
    one, other = (1.2**-4, 1.2**2) if is_across else (1.2**2, 1.0 / 1.2)
    stress = SHEAR * deviator(one * line + other * (np.eye(3) - line))
    found = forces(made, drawn)
    inner = ((drawn > 1e-9) & (drawn < 0.02 - 1e-9)).all(axis=1)
    assert np.abs(found[inner]).max() < 1e-12 * np.abs(found).max()
    # Virtual work: Σ f ⊗ X over all nodes is -V σ.
    np.testing.assert_allclose(
        -np.einsum("ax,ak->xk", found, drawn) / made.volume.sum(), stress, atol=1e-10 * SHEAR
    )
    total, volume = made.node_stress(drawn)
    np.testing.assert_allclose(
        total / volume[:, None, None], np.tile(stress, (len(drawn), 1, 1)), atol=1e-10 * SHEAR
    )
    np.testing.assert_allclose(volume.sum(), 0.02**3, rtol=1e-13)


@pytest.mark.parametrize("name", SHAPES)
def test_elements_that_are_alike_share_what_they_are_as_drawn(name):
    count = len(mesh(name, displaced=0.0)[1])
    made, _ = solid(name, NeoHookean(), (AXIS, False, uneven(count)), displaced=0.0)
    if name == "hexahedron":
        # Their prestretch is a number of each, beside what they are as drawn.
        assert len(made.drawn.volume) == 1
    some = made.only(np.arange(1, count, 2))
    np.testing.assert_array_equal(some.prestretch.stretch, 1.2)
    table = some.table(np.arange(200), None, None)
    blocks = -(-len(some.row) // LANES)
    assert len(np.unique(table.key)) == min(len(np.unique(some.row)), blocks)


@pytest.mark.parametrize(("is_across", "along"), [
    (False, (0.6, 0.0, 0.8)), (True, (0.96, 0.0, 0.28)),
])  # fmt: skip
def test_fibres_at_an_angle_are_stretched_as_lines_of_the_drawn_body(is_across, along):
    k1, k2, stretch = 7e3, 0.8, 1.2

    def fibres(count):
        parts = (np.full(count, each) for each in (k1, k2, 0.0))
        return SolidFibres(np.tile(along, (count, 1, 1)), *parts)

    axis = np.array([0.0, 0.0, 1.0])
    made, drawn = solid("hexahedron", NeoHookean(), (axis, is_across, stretch), fibres=fibres)
    bare, _ = solid("hexahedron", NeoHookean(), (axis, is_across, stretch))
    # How long a line along the fibres was before the body was stretched.
    x, z = (1.0 / stretch, stretch**2) if is_across else (stretch**0.5, 1.0 / stretch)
    e = 1.0 / ((x * along[0]) ** 2 + (z * along[2]) ** 2) - 1.0
    assert e > 0.1
    stored = 0.02**3 * 0.5 * k1 / k2 * np.expm1(k2 * e * e)
    found = made.energy(0.0, drawn) - bare.energy(0.0, drawn)
    assert found == pytest.approx(stored, rel=1e-10)


# --- scenes ---------------------------------------------------------------------------------

SCENE = """\
language 1
tissue skin {{
  Young's modulus = 10 kPa; Poisson's ratio = {ratio}; density = 1000 kg/m^3
  retardation time = 5 ms; prestress = {prestress}
}}
body bar {{
  made of elements
  mesh is lattice {{ cell = 2.5 mm; box from (0, 0, 0) mm to (40, 5, 5) mm }}
  tissue is skin; prestress {way}
}}
set left = nodes of bar where x < 0.1 mm
set right = nodes of bar where x > 39.9 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ {script} }}
simulate {{ duration = 1 ms }}
output {{ trajectory every 1 ms; force of left every 1 ms; force of right every 1 ms }}
"""


def settled(way, *, prestress="20 %", ratio=0.49, script="at 0 s: settle"):
    """Return the drawn bar and the one at rest, shape (node, 3)."""
    text = SCENE.format(way=way, prestress=prestress, ratio=ratio, script=script)
    outcome, _ = carried_out(compiled_scene(text))
    return outcome.state.network.position, outcome.state.position


@pytest.mark.parametrize(("way", "stretch"), [
    ("along (1, 0, 0)", (0.8, 0.8**-0.5, 0.8**-0.5)),
    ("across (0, 0, 2)", (0.8, 0.8, 0.8**-2)),
])  # fmt: skip
@pytest.mark.parametrize("ratio", [0.25, 0.49])
def test_a_free_block_takes_the_shape_without_stress(way, stretch, ratio):
    drawn, found = settled(way, ratio=ratio)
    assert np.ptp(found, axis=0) == pytest.approx(np.ptp(drawn, axis=0) * stretch, rel=1e-9)


def test_pressed_tissue_becomes_longer():
    drawn, found = settled("along (1, 0, 0)", prestress="-10 %")
    assert np.ptp(found[:, 0]) == pytest.approx(1.1 * np.ptp(drawn[:, 0]), rel=1e-9)


HELD = "at 0 s: { fix left; fix right; settle }"
CUT = "at 0 s: { fix left; fix right; cut bar along plane through (19, 0, 0) mm facing "


def test_a_wound_opens_by_what_both_sides_contract():
    drawn, uncut = settled("along (1, 0, 0)", script=HELD)
    assert np.abs(uncut - drawn)[:, 0].max() < 2e-4
    _, found = settled("along (1, 0, 0)", script=CUT + "(1, 0, 0); settle }")
    found = found[: len(drawn)]
    # Both sides become shorter by a fifth, but for the ends, which cannot become wider, and so
    # contract more than that: by up to a width.
    for edge, length in ((17.5e-3, 17.5e-3), (20e-3, -20e-3)):
        face = np.isclose(drawn[:, 0], edge)
        contracted = (drawn - found)[face, 0].mean() / length
        assert 0.15 < contracted < 0.21
