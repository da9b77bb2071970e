"""Ties ahead of blades: slits against closed forms, areas, forces and stable steps."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from tests.cuts.scenes import begun, cut_faces, fastest, momentum, tied_area, volume
from tests.hand_net import Diary
from tests.validate.scenes import compiled_scene
from tissuec.geometry.blade_sections import beyond, shares_of_polygons
from tissuec.geometry.cut_cells.sections import facet_sizes

A = 10e-3  # half of the length of slits [m]
MODULUS, POISSON, STRESS = 10e3, 0.3, 10.0
SHEAR = MODULUS / (2.0 + 2.0 * POISSON)
PLATE = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }}
body plate {{
  mesh is lattice {{
    cell = {cell} mm; box from ({left}, {low}, 0) mm to ({right}, {high}, {cell}) mm
  }}
  made of elements; tissue is gel
}}
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{
{cuts}
}}
simulate {{ duration = 1 s }}
"""


def slit(angle, first, last):
    """Return the sentence of a slit through the origin, between distances from it [m]."""
    way = np.array([np.cos(angle), np.sin(angle)])
    ends = [f"({x:.12g}, {y:.12g}, 0) mm" for x, y in 1e3 * np.outer([first, last], way)]
    facing = f"({-way[1]:.12g}, {way[0]:.12g}, 0)"
    return f"at 0 s: cut plate along line from {ends[0]} to {ends[1]} facing {facing}"


def plate(count, shift, *cuts):
    """Return the state of a plate of the size 4 a, of some cells along 2 a, after cuts.

    Args:
        shift: Of the lattice, in cells, shape (2,).
    """
    cell = 2e3 * A / count
    low = -2e3 * A + cell * np.asarray(shift)
    (left, low), (right, high) = low, low + 4e3 * A
    return begun(
        PLATE.format(
            cell=f"{cell:.12g}", left=left, right=right, low=low, high=high,
            cuts="\n".join(cuts),
        )
    )  # fmt: skip


def exact(place, angle, plane_stress=False):
    """Return displacements [m] around a slit of 2 a under equal tension on all sides.

    H. M. Westergaard, J. Appl. Mech. 6:A49, 1939: with Z = S z/sqrt(z² - a²),
    2 μ u = (κ - 1)/2 Re ∫Z - y Im Z, 2 μ v = (κ + 1)/2 Im ∫Z - y Re Z.
    """
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    x, y = turn @ place[:, :2].T
    z = x + 1j * y
    root = np.sqrt(z - A) * np.sqrt(z + A)
    whole, steep = STRESS * root, STRESS * z / np.where(root == 0.0, 1.0, root)
    kappa = (3.0 - POISSON) / (1.0 + POISSON) if plane_stress else 3.0 - 4.0 * POISSON
    u = (kappa - 1.0) / 2.0 * whole.real - y * steep.imag
    v = (kappa + 1.0) / 2.0 * whole.imag - y * steep.real
    found = np.zeros_like(place)
    found[:, :2] = np.stack([u, v], axis=1) @ turn / (2.0 * SHEAR)
    return found


def solved(state, angle, plane_stress=False):
    """Return small displacements of all nodes [m], and the energy [J]."""
    place = state.network.position
    fields = [each for each in state.fields if hasattr(each, "element_matrices")]
    every = np.arange(len(place))
    stiff = sum(each.matrix(0.0, place, every, len(place)) for each in fields).tocsr()
    low, high = place.min(axis=0), place.max(axis=0)
    outer = ((np.abs(place - low) < 1e-9) | (np.abs(place - high) < 1e-9))[:, :2].any(axis=1)
    known = np.zeros((len(place), 3), dtype=bool)
    known[outer, :2] = True
    known[:, 2] = not plane_stress
    if plane_stress:
        known[np.abs(place[:, 2] - low[2]) < 1e-9, 2] = True
    known[~state.free] = True
    moved = np.where(outer[:, None], exact(place, angle, plane_stress), 0.0).ravel()
    known = known.ravel()
    moved[~known] = spsolve(stiff[~known][:, ~known], -(stiff[~known] @ moved))
    energy = 0.5 * moved @ (stiff @ moved)
    return moved.reshape(-1, 3), energy


def opening(state, moved, angle):
    """Return distances from the middle of the slit, and openings [m], at middles of cells."""
    found = []
    normal = np.array([-np.sin(angle), np.cos(angle), 0.0])
    way = np.array([np.cos(angle), np.sin(angle), 0.0])
    drawn, place = state.cut_cells, state.network.position
    points, shifted = drawn.points.beside(place), drawn.points.beside(moved)
    alive = state.alive[drawn.borders] & (drawn.cuts != 0)
    middles, gaps = (each[drawn.triangles[alive]].mean(axis=1) for each in (points, shifted))
    a, b, c = points[drawn.triangles[alive]].swapaxes(0, 1)
    front = np.cross(b - a, c - a) @ normal < 0.0  # seen from outside of the part in front
    keys = [
        np.round(each @ way / 1e-9).astype(int) for each in (middles[front], middles[~front])
    ]
    for key in np.intersect1d(*keys):
        each = [
            gaps[side][own == key].mean(axis=0)
            for side, own in zip((front, ~front), keys, strict=True)
        ]
        found.append((1e-9 * key, (each[0] - each[1]) @ normal))
    return np.array(found).T


def in_the_middle(place, gap, plane_stress=False):
    """Return by how much the opening of the middle third differs from the exact one."""
    stiff = MODULUS if plane_stress else MODULUS / (1.0 - POISSON**2)
    own = np.abs(place) < 0.3 * A
    expected = 4.0 * STRESS / stiff * np.sqrt(A**2 - place[own] ** 2)
    return (gap[own] / expected).mean() - 1.0


RANDOM = np.random.default_rng(5)
CASES = [(RANDOM.uniform(5, 40), RANDOM.uniform(-0.5, 0.5, 2)) for _ in range(4)]


def errors(count, cases, plane_stress=False):
    found = []
    for degrees, shift in cases:
        angle = np.deg2rad(degrees)
        state = plate(count, shift, slit(angle, -A, A))
        moved, _ = solved(state, angle, plane_stress)
        found.append(in_the_middle(*opening(state, moved, angle), plane_stress))
    return np.array(found)


def test_the_opening_of_a_slit_is_that_of_a_crack():
    """Within 3 % at 20 elements along the slit, and half of the error at 10, or less.

    The front is singular, so that errors are of first order; places of the front in its element
    scatter by half a percent.
    """
    coarse, fine = (errors(count, CASES[:2]) for count in (10, 20))
    assert np.abs(fine).max() < 0.03
    assert abs(fine.mean()) < 0.6 * abs(coarse.mean())
    assert np.abs(errors(20, CASES[:1], plane_stress=True)).max() < 0.03


@pytest.mark.slow
def test_the_opening_of_a_slit_converges():
    found = [errors(count, CASES) for count in (10, 20, 40)]
    assert np.abs(found[1]).max() < 0.03 and np.abs(found[2]).max() < 0.012
    means = np.abs([each.mean() for each in found])
    assert (means[1:] < 0.7 * means[:-1]).all()


def test_energy_is_released_as_the_end_of_a_slit_moves():
    """Steps of h/8: on average G, in no step more than two and a half times as much.

    Without ties, all is released at once for each element, 8 G h/8. (Over an element, energies
    at its ends are those of two meshes alike; the mean is of second order in h/a.)
    """
    rate = np.pi * A * STRESS**2 * (1.0 - POISSON**2) / MODULUS
    count, angle, energies = 12, 0.0, []
    step = 2.0 * A / count / 8
    for k in range(-4, 5):
        state = plate(count, (0.3, 0.45), slit(angle, -A, A + k * step))
        energies.append(solved(state, angle)[1] / (2.0 * A / count))  # per thickness
    released = -np.diff(energies) / (rate * step)
    assert released.mean() == pytest.approx(1.0, abs=0.06)
    assert released.min() > 0.05 and released.max() < 2.5


BLOCK = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = NU; density = 1000 kg/m^3 }
body plate {
  mesh is MESH
  made of elements; tissue is gel
}
environment { gravity = (0, 0, 0) m/s^2 }
script {
ORDERS
}
simulate { duration = 1 s }
"""
LATTICE = "lattice { cell = 2 mm; box from (0, 0, 0) mm to (12, 8, 4) mm }"
WEDGES = (
    "thick tube { axis from (0, 0, 0) mm to (12, 0, 0) mm; inner radius = 4 mm\n"
    "  outer radius = 8 mm; rings = 5; sides = 12; layers = 2 }"
)


def block(*orders, mesh=LATTICE, poisson="0.3", done=None):
    text = BLOCK.replace("MESH", mesh).replace("NU", poisson)
    compiled = compiled_scene(text.replace("ORDERS", "\n".join(orders)))
    state = compiled.plan.start(compiled.network)
    for event in compiled.plan.events[:done]:
        event.action.apply(state, Diary())
    return state, [event.action for event in compiled.plan.events]


def line(x, first, last, facing="(1, 0, 0)", at="0 s"):
    along = f"from ({x}, {first}, 0) mm to ({x}, {last}, 0) mm facing {facing}"
    return f"at {at}: cut plate along line {along}"


def ties(state):
    (found,) = state.of_kind("ties")
    return found


@pytest.mark.parametrize("mesh", [LATTICE, WEDGES])
def test_ties_cover_what_the_blade_does_not(mesh):
    """The sections of divided elements are the area within the blade and that of the ties."""
    state, _ = block(line(5.3, -10, 3.1), mesh=mesh)
    whole, _ = block(
        "at 0 s: cut plate along plane through (5.3, 0, 0) mm facing (1, 0, 0)", mesh=mesh
    )
    found, sections = tied_area(state, "plate"), 0.5 * facet_sizes(cut_faces(state)).sum()
    if mesh == LATTICE:
        assert found == pytest.approx(0.9e-3 * 4e-3, rel=1e-9)
        assert sections - found == pytest.approx(3.1e-3 * 4e-3, rel=1e-9)
    assert 0.0 < found < 0.5 * sections
    assert not len(whole.tied["plate"]) and not whole.of_kind("ties")


def test_the_force_of_ties_is_that_of_their_openings():
    """Parts moved apart by a vector: k A of it, and nothing if they turn together."""
    state, _ = block(line(5.3, -1, 5.1))
    field, tied, rng = ties(state), state.tied["plate"], np.random.default_rng(2)
    place, gap = state.position, np.array([1e-4, -2e-4, 3e-4])
    forces = np.zeros_like(place)
    turned = place @ np.linalg.qr(rng.normal(size=(3, 3)))[0] + 1.0
    field.add_forces(0.0, turned, np.zeros_like(state.velocity), forces)
    scale = field.stiffness.sum() * np.abs(turned).max()
    assert np.abs(forces).max() < 1e-12 * scale
    half = field.nodes.shape[1] // 2
    point = np.einsum("ka,kax->kx", field.weights[:, :half], place[field.nodes[:, :half]])
    assert np.abs(point[:, 0] - 5.3e-3).max() < 1e-15
    assert (point[:, 1] > 5.1e-3).all() and (point[:, 1] < 6e-3).all()
    opened = np.einsum("ka,kax->kx", field.weights, place[field.nodes])
    assert np.abs(opened).max() < 1e-17
    areas = 0.9e-3 * 4e-3
    # 3 E/h with h = 8 mm³ / 4 mm²
    assert field.stiffness.sum() == pytest.approx(3.0 * 10e3 / 2e-3 * areas, rel=1e-9)
    moved = place.copy()
    apart = np.unique(field.nodes[:, :half])
    only = np.setdiff1d(apart, field.nodes[:, half:])
    moved[only] += gap
    expected = (
        0.5
        * field.stiffness
        @ (np.einsum("ka,ka->k", field.weights, np.isin(field.nodes, only)) ** 2)
    )
    assert field.energy(0.0, moved) == pytest.approx(expected * (gap @ gap), rel=1e-9)
    assert tied.stiffness == pytest.approx(1.5e7, rel=1e-12)


@pytest.mark.parametrize("strain", [0.0, 0.03])
def test_a_blade_that_goes_on_parts_what_was_tied(strain):
    """In a strip that was stretched, too: it continues the faces that have opened.

    There, sections of new elements are slanted by what the blade is off these faces.
    """
    orders = [line(5.3, -1, 5.1), line(5.3 * (1 + strain), 4, 6.6, at="0.1 s"),
              line(5.3 * (1 + strain), 6, 10, at="0.2 s")]  # fmt: skip
    state, actions = block(*orders, done=1)
    if strain:
        own = np.flatnonzero(state.free)
        ahead = np.zeros(len(state.position))
        body = state.cut_bodies["plate"]
        for parts in body.parts:
            ahead[parts.nodes[parts.sides[:, -1] > 0]] = 1.0
        state.position[own, 0] *= 1.0 + strain
        tied = np.unique(ties(state).nodes)
        ahead[tied] = 0.0
        state.position[own, 0] += 2e-4 * ahead[own]
    actions[1].apply(state, Diary())
    left = 8.0 - 6.6
    assert tied_area(state, "plate") == pytest.approx(
        left * 1e-3 * 4e-3, rel=1e-3 if strain else 1e-9
    )
    assert state.joined_pairs.max() < state.network.node_count
    actions[2].apply(state, Diary())
    assert not state.of_kind("ties") and not len(state.tied["plate"])
    assert volume(state) == pytest.approx(12e-3 * 8e-3 * 4e-3, rel=1e-12)


def test_a_cut_across_keeps_ties_on_both_sides_of_it():
    """Mass, momentum and volume stay the same, and the area of the ties."""
    across = line(0, -1, 9, "(0.02, 0, 1)", "0.1 s").replace(", 0) mm", ", 1.3) mm")
    state, actions = block(line(5.3, -1, 5.1), across, done=1)
    rng = np.random.default_rng(3)
    state.velocity[:] = 0.01 * rng.normal(size=state.velocity.shape)
    state.follow_hosts()
    before, mass, area = momentum(state), state.inertia.sum(), tied_area(state, "plate")
    actions[1].apply(state, Diary())
    assert state.inertia.sum() == pytest.approx(mass, rel=1e-14)
    np.testing.assert_allclose(momentum(state), before, atol=1e-13 * np.abs(before).max())
    assert tied_area(state, "plate") == pytest.approx(area, rel=1e-12)
    assert state.alive[state.tied["plate"].entities].all()
    opened = np.einsum("ka,kax->kx", ties(state).weights, state.position[ties(state).nodes])
    assert np.abs(opened).max() < 1e-15


@pytest.mark.parametrize("poisson", ["0.3", "0.45", "0.49"])
def test_the_stable_step_stays_at_least_half(poisson):
    """The largest frequency of the block with ties, over that of the block as drawn."""
    rng = np.random.default_rng(11)
    mesh = "lattice { cell = 2 mm; box from (0, 0, 0) mm to (8, 6, 4) mm }"
    whole, _ = block(line(4, 20, 30), mesh=mesh, poisson=poisson)
    first = fastest(whole)
    for _ in range(4):
        x, y, angle = rng.uniform(2, 6), rng.uniform(1, 5), rng.uniform(-0.5, 0.5)
        way = np.array([np.sin(angle), np.cos(angle)])
        start, stop = np.array([x, y]) - 9.0 * way, np.array([x, y])
        ends = [f"({a:.6g}, {b:.6g}, 0) mm" for a, b in (start, stop)]
        facing = f"({way[1]:.9g}, {-way[0]:.9g}, 0)"
        order = f"at 0 s: cut plate along line from {ends[0]} to {ends[1]} facing {facing}"
        state, _ = block(order, mesh=mesh, poisson=poisson)
        assert state.of_kind("ties")
        assert np.sqrt(first / fastest(state)) > 0.5


def test_blades_that_close_part_what_a_blade_parts_at_once():
    """Nothing moves in between: the same parts, areas and ties, whatever the steps."""
    at_once, _ = block(line(5.3, -1, 5.1))
    closing, actions = block(line(5.3, -1, 5.1).replace("at 0 s", "from 0 s to 1 s"), done=0)
    diary = Diary()
    actions[0].apply(closing, diary)
    assert 8 <= len(diary.added) <= 16  # four steps for each of three elements
    diary.play(closing, 1.0)
    assert tied_area(closing, "plate") == pytest.approx(tied_area(at_once, "plate"), rel=1e-9)
    assert ties(closing).stiffness.sum() == pytest.approx(
        ties(at_once).stiffness.sum(), rel=1e-7
    )
    bodies = (each.cut_bodies["plate"].parts for each in (at_once, closing))
    for one, other in zip(*bodies, strict=True):
        assert (one.nodes == other.nodes).all() and len(one) == len(other)


def test_what_is_beyond_a_blade_and_what_is_within_it_make_up_triangles():
    rng = np.random.default_rng(1)
    plain = rng.uniform(-1.0, 2.0, (400, 3, 2))
    size = lambda x: 0.5 * np.abs(np.linalg.det(x[:, 1:] - x[:, :1]))  # noqa: E731
    for limited in ((True, False), (False, True), (True, True)):
        which, shares = beyond(plain, limited, 0.6)
        parts = shares @ plain[which]
        outside = np.bincount(which, size(parts), 400)
        scaled = plain / [0.6, 1.0]
        within = shares_of_polygons(scaled, limited) * size(plain)
        np.testing.assert_allclose(outside + within, size(plain), atol=1e-12)
