"""Hexahedra in bending, torsion and uniform strain, against theories of beams and integrals."""

from itertools import product

import numpy as np
import pytest
from scipy.linalg import solve
from scipy.optimize import brentq
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import spsolve

from tests.derivatives import forces
from tests.forces.test_elements import SPAN, with_flat_sides
from tests.forces.test_elements import mesh as distorted
from tests.laws.test_solid_laws import KEEPING, SAMPLES
from tissuec.core.arrays import rigid_motions
from tissuec.core.structs import replace
from tissuec.forces.solids.bent_elements import kind_of
from tissuec.forces.solids.elements import SolidMaterial
from tissuec.forces.solids.solid_strain import Prestretch, SolidFibres
from tissuec.geometry.bent_cells import BentCells
from tissuec.geometry.elements import SHAPES
from tissuec.laws.solid import SOLID_LAWS
from tissuec.laws.solid.invariants import CoupledNeoHookean, NeoHookean
from tissuec.laws.solid.volume import VOLUMES

YOUNG = 10e3  # [Pa]
CORNERS = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0),
           (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]  # fmt: skip


def bar(counts, sides, poisson, law=None):
    """Return a bar of equal boxes from (0, 0, 0) on, and where its nodes are.

    Args:
        counts: Of cells along each side.
        sides: Of the bar [m].
    """
    steps = [np.linspace(0.0, side, n + 1) for side, n in zip(sides, counts, strict=True)]
    places = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(places)).reshape([n + 1 for n in counts])
    nodes = np.stack(
        [number[tuple(np.s_[o : o + n] for o, n in zip(each, counts, strict=True))].ravel()
         for each in CORNERS], axis=1,
    )  # fmt: skip
    return made_of("hexahedron", places, nodes, poisson, law), places


def made_of(shape, places, nodes, poisson, law=None, **more):
    """Return elements of one material; further parts of it may be given."""
    count = len(nodes)
    shear, bulk = YOUNG / 2.0 / (1.0 + poisson), YOUNG / 3.0 / (1.0 - 2.0 * poisson)
    material = SolidMaterial(
        np.full(count, shear), np.full(count, bulk), np.zeros(count), np.zeros(count, int),
        (law or NeoHookean(),), **more,
    )  # fmt: skip
    return kind_of(SHAPES[shape]).of("bar", SHAPES[shape], nodes, places, material, 0, SPAN)


def matrix_at(elements, places):
    """Return the matrix of all nodes [N/m], shape (3 node, 3 node)."""
    return elements.matrix(0.0, places, np.arange(len(places)), len(places)).toarray()


def of_edges(places):
    """Return ∫ N_a N_b of straight elements between places in order [m], (place, place)."""
    found = np.zeros((len(places), len(places)))
    for k, long in enumerate(np.diff(places)):
        found[k : k + 2, k : k + 2] += long / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    return found


# --- bending ----------------------------------------------------------------------------------


def moved_by(elements, places, load):
    """Return how far forces without a resultant move nodes [m], shape (3 node,)."""
    # Rigid motions are the only ones without force: a spring each, which bears nothing.
    rigid = rigid_motions(places - places.mean(axis=0)).reshape(-1, 6)
    rigid, stiff = np.linalg.qr(rigid)[0], matrix_at(elements, places)
    stiff += np.trace(stiff) / len(stiff) * rigid @ rigid.T
    return solve(stiff, load.ravel(), assume_a="pos")


def bent_by_moments(ratio, across, poisson):
    """Return the work of moments at the ends of a bar over that of the theory of beams.

    Its section is a square of 1 m, and σ = y at the ends, so that the moment is that of the
    section, 1/12 m⁴ Pa/m, and an end turns by L/E.
    """
    long = ratio / across * 8
    elements, places = bar((8, across, across), (long, 1.0, 1.0), poisson)
    steps = np.linspace(0.0, 1.0, across + 1)
    pull = np.outer(of_edges(steps) @ (steps - 0.5), of_edges(steps).sum(axis=1))
    load = np.zeros_like(places)
    for x, sign in ((0.0, -1.0), (long, 1.0)):
        load[np.isclose(places[:, 0], x), 0] = sign * pull.ravel()
    return load.ravel() @ moved_by(elements, places, load) / (long / 12.0 / YOUNG)


RATIOS = (0.1, 0.25, 1.0, 4.0, 20.0)  # edges along the bar over those across


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.45, 0.49])
def test_boxes_bend_as_beams_at_any_ratio_of_edges(poisson):
    found = {
        (ratio, across): bent_by_moments(ratio, across, poisson)
        for ratio, across in product(RATIOS, (1, 2))
    }
    # One across is exact. Two share the strain across the plane of bending, which their
    # bilinear sections follow to second order only.
    wrong = {
        each: value for each, value in found.items()
        if abs(value - 1.0) > (1e-7 if each[1] == 1 else 0.01)
    }  # fmt: skip
    assert not wrong


# --- torsion ----------------------------------------------------------------------------------


def torsion_of_square(terms=30):
    """Return the constant of a square of side 1 (St Venant's series), dimensionless."""
    odd = np.arange(1, 2 * terms, 2)
    return 1.0 / 3.0 * (1.0 - 192.0 / np.pi**5 * (np.tanh(odd * np.pi / 2.0) / odd**5).sum())


def twisted(across, poisson, turn=1e-3):
    """Return the torque of a bar whose ends turn and may warp, over that of St Venant."""
    long = 3.0
    elements, places = bar((6, across, across), (long, 1.0, 1.0), poisson)
    stiff = matrix_at(elements, places)
    at_end = np.isclose(places[:, 0], 0.0) | np.isclose(places[:, 0], long)
    held = np.zeros(places.shape, dtype=bool)
    held[at_end, 1:] = True
    held[0, 0] = True
    moved = np.zeros_like(places)
    angle = turn * places[:, 0] / long
    moved[:, 1], moved[:, 2] = -angle * (places[:, 2] - 0.5), angle * (places[:, 1] - 0.5)
    fixed, flat = held.ravel(), moved.ravel()
    rest = stiff[np.ix_(~fixed, fixed)] @ flat[fixed]
    flat[~fixed] = solve(stiff[np.ix_(~fixed, ~fixed)], -rest, assume_a="pos")
    shear = YOUNG / 2.0 / (1.0 + poisson)
    return flat @ stiff @ flat / (shear * torsion_of_square() * turn**2 / long)


@pytest.mark.parametrize(("across", "bound"), [(4, 0.05), (6, 0.025)])
def test_bars_resist_torsion_as_st_venant_says(across, bound):
    assert twisted(across, 0.3) == pytest.approx(1.0, abs=bound)


# --- patches ----------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.4999])
def test_distorted_elements_pass_the_patch_test(shape, poisson):
    places, nodes = distorted(shape, cells=3, displaced=0.3)
    if shape == "wedge":
        places = with_flat_sides(places)
    elements = made_of(shape, places, nodes, poisson)
    inside = ((places > 1e-9) & (places < 0.02 - 1e-9)).all(axis=1)
    stretch = np.array([[1.2, 0.1, -0.05], [0.0, 0.9, 0.15], [0.1, -0.1, 1.05]])
    pushed = forces(elements, places @ stretch.T)
    if shape == "tetrahedron":
        # Nodes on distorted edges stay in their middles.
        assert inside.sum() > 8
    assert inside.any()
    # Of sums of some ten forces of elements that cancel.
    assert np.abs(pushed[inside]).max() < 1e-12 * np.abs(pushed).max()


# --- boxes and other cells -------------------------------------------------------------------


@pytest.mark.parametrize("name", ["neo hookean", "yeoh", "mooney rivlin"])
@pytest.mark.parametrize("is_fibred", [False, True], ids=["", "fibres and prestretch"])
def test_boxes_have_the_forces_and_matrices_of_other_cells(name, is_fibred):
    """Those of boxes have loops of their own."""
    law = law_of(name, "logarithmic")
    boxes, places = bar((2, 1, 1), (1.0, 0.7, 0.4), 0.3, law)
    if is_fibred:
        along = np.broadcast_to([[0.6, 0.8, 0.0], [0.0, 0.6, -0.8]], (2, 2, 3))
        numbers = (np.full(2, each) for each in (3e3, 0.5, 0.1))
        stretch = Prestretch(np.array([0.48, 0.6, 0.64]), False, np.full(2, 1.2))
        more = {"fibres": SolidFibres(along, *numbers), "prestretch": stretch}
        boxes = made_of("hexahedron", places, boxes.nodes, 0.3, law, **more)
    assert boxes.are_boxes
    rows = BentCells.of(places[boxes.nodes][:1]).rows
    others = replace(boxes, cells=rows, are_boxes=False)
    random = np.random.default_rng(1)
    state = 1.1 * places + random.uniform(-0.1, 0.1, places.shape)
    for found, due in (
        (forces(boxes, state), forces(others, state)),
        (matrix_at(boxes, state), matrix_at(others, state)),
        (boxes.energies(state), others.energies(state)),
    ):
        np.testing.assert_allclose(found, due, rtol=0.0, atol=1e-13 * np.abs(due).max())
    each, whole = boxes.element_matrices(state, exact=True), np.zeros((36, 36))
    for matrix, nodes in zip(each.reshape(2, 24, 24), boxes.nodes, strict=True):
        place = (3 * nodes[:, None] + np.arange(3)).ravel()
        whole[np.ix_(place, place)] += matrix
    assert np.abs(whole - matrix_at(boxes, state)).max() < 1e-14 * np.abs(whole).max()
    size = 1e-6
    way = size * random.normal(size=places.shape)
    by_difference = (forces(boxes, state - way) - forces(boxes, state + way)) / 2.0
    pushed = (matrix_at(boxes, state) @ way.ravel()).reshape(way.shape)
    # Differences are exact up to (1e-6)², and rounding of 1e-16 of forces over 1e-6 of changes.
    assert np.abs(by_difference - pushed).max() < 1e-8 * np.abs(pushed).max()


# --- large strains ----------------------------------------------------------------------------


def cook(poisson, cells):
    """Return how far the corner of Cook's membrane rises, in its units.

    (J. C. Simo, F. Armero, Int. J. Numer. Meth. Eng. 33:1413, 1992: a tapered panel, held at
    its left, whose right edge of 16 is pushed upwards by 100; plane strain, E = 240.565.)
    """
    law = NeoHookean(volume="quadratic")
    unit, square = bar((cells, cells, 1), (1.0, 1.0, 1.0), poisson, law)
    along, up = square[:, 0], square[:, 1]
    high = 44.0 * along + (44.0 - 28.0 * along) * up
    places = np.stack([48.0 * along, high, square[:, 2]], axis=1)
    scale = 240.565 / YOUNG  # of forces
    elements = made_of("hexahedron", places, unit.nodes, poisson, law)
    free = np.ones(places.shape, dtype=bool)
    free[:, 2] = free[along == 0.0] = False
    load, steps = np.zeros_like(places), np.linspace(0.0, 1.0, cells + 1)
    right = along == 1.0
    pull = of_edges(steps).sum(axis=1)[np.rint(cells * up[right]).astype(int)]
    load[right, 1] = 0.5 * 100.0 / scale * pull
    position, chosen = places.copy(), free.ravel()
    for part in np.linspace(0.125, 1.0, 8):
        for _ in range(30):
            left = (forces(elements, position) + part * load).ravel()[chosen]
            stiff = csc_matrix(matrix_at(elements, position)[np.ix_(chosen, chosen)])
            step = spsolve(stiff, left)
            position[free] += step
            if np.abs(step).max() < 1e-7:
                break
        else:
            raise AssertionError("no equilibrium")
    corner = np.argmax(along + up - 0.1 * square[:, 2])
    return position[corner, 1] - places[corner, 1]


@pytest.mark.parametrize(
    ("poisson", "due", "bound"), [(0.3, 7.830, 0.02), (0.4999, 6.920, 0.035)]
)
def test_cooks_membrane_rises_as_that_of_quadratic_elements(poisson, due, bound):
    """Against felupe, 32 x 32 quadrilaterals of nine nodes with pressures of their own."""
    assert cook(poisson, 8) == pytest.approx(due, rel=bound)


#: Laws that say what a change of volume costs, and others.
STORED = [(name, volume) for name in KEEPING for volume in VOLUMES]
STORED += [(name, None) for name in SAMPLES if name not in KEEPING]


#: The energy of Saint Venant and Kirchhoff is a function of FᵀF, the same inside out.
TURNED = [one for one in STORED if one[0] != "saint venant kirchhoff"]


@pytest.mark.parametrize(("name", "volume"), TURNED)
def test_a_cube_that_is_turned_inside_out_stores_ever_more(name, volume):
    elements, places = bar((1, 1, 1), (1.0, 1.0, 1.0), 0.3, law_of(name, volume))
    heights = np.linspace(1.0, -1.5, 51)
    energies = [elements.energy(0.0, places * [1.0, 1.0, height]) for height in heights]
    assert (np.diff(energies) > 0.0).all()


@pytest.mark.parametrize(("name", "volume"), STORED)
def test_no_state_stores_less_than_that_at_rest(name, volume):
    random = np.random.default_rng(0)
    for poisson in (0.0, 0.3, 0.45):
        elements, places = bar((2, 2, 2), (1.0, 1.0, 1.0), poisson, law_of(name, volume))
        for size in (0.3, 1.0, 1.5):
            states = random.uniform(-size, size, (10, *places.shape))
            assert min(elements.energy(0.0, state) for state in states) > 0.0


def law_of(name, volume):
    """Return a law with numbers that tests of laws have, too."""
    more = {} if volume is None else {"volume": volume}
    return SOLID_LAWS[name](**SAMPLES[name], **more)


def pressed(law, poisson, heights):
    """Return the forces of a cube of 1 m with free sides at heights [N], shape (height,)."""
    elements, drawn = bar((2, 2, 2), (1.0, 1.0, 1.0), poisson, law)
    free = drawn > 1e-9  # three planes of symmetry
    top = drawn[:, 2] > 1.0 - 1e-9
    free[top, 2] = False
    position, chosen, found = drawn.copy(), free.ravel(), []
    for height in heights:
        position[:, 2] *= height / position[top, 2].mean()
        for _ in range(30):
            pushed = forces(elements, position)
            if np.abs(pushed[free]).max() < 1e-10 * YOUNG:
                break
            stiff = matrix_at(elements, position)[np.ix_(chosen, chosen)]
            position[free] += solve(stiff, pushed[free])
        found.append(pushed[top, 2].sum())
    return np.array(found)


def by_closed_form(is_coupled, poisson, height):
    """Return the force of a cube of 1 m whose sides bear no stress [N]."""
    shear, bulk = YOUNG / 2.0 / (1.0 + poisson), YOUNG / 3.0 / (1.0 - 2.0 * poisson)

    def stress(along, *others):
        """Return the first Piola-Kirchhoff stress along one principal direction [Pa]."""
        log = np.log(along * np.prod(others))
        if is_coupled:
            return shear * (along - 1.0 / along) + (bulk - shear / 1.5) * log / along
        mean = (along**2 + np.square(others).sum()) / 3.0
        return shear * np.exp(-log / 1.5) * (along - mean / along) + bulk * log / along

    side = brentq(lambda side: stress(side, side, height), 0.5, 4.0, xtol=1e-14)
    return -stress(height, side, side)


@pytest.mark.parametrize("poisson", [0.0, 0.25, 0.3, 0.45])
@pytest.mark.parametrize("law", [NeoHookean(), CoupledNeoHookean()], ids=["", "coupled"])
def test_a_cube_with_free_sides_resists_ever_more_when_pressed(law, poisson):
    heights = np.linspace(0.95, 0.3, 14)
    found = pressed(law, poisson, heights)
    due = [by_closed_form(law == CoupledNeoHookean(), poisson, each) for each in heights]
    np.testing.assert_allclose(found, due, rtol=1e-6)
    assert (np.diff(found) > 0.0).all()
