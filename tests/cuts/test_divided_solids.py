"""Solids that blades divide: what is kept, what is held, and what moves apart."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from tests.contact.scenes import play
from tests.cuts.scenes import (
    END,
    GEL,
    UNUSED,
    ahead_of,
    cut,
    momentum,
    state_of,
    volume,
)
from tests.hand_net import Diary
from tests.validate.scenes import compiled_scene
from tissuec.forces.acting.embedding import EmbeddedNodes
from tissuec.mechanics.cut_surfaces import NotDivisible
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.snapshot import Snapshot

BODY = """body block { mesh is MESH; tissue is gel }
set base = nodes of block where x < 0.01 mm
environment { gravity = (0, 0, 0) m/s^2 }
"""
LATTICE = "lattice { cell = 2.5 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }"
ROUND = (
    "thick tube { axis from (0, 0, 0) mm to (20, 0, 0) mm; inner radius = 4 mm\n"
    "  outer radius = 8 mm; rings = 5; sides = 12; layers = 2 }"
)
OF_27_NODES = "; made of quadratic elements"
BRICKS = LATTICE.replace("2.5 mm", "5 mm") + OF_27_NODES
BENT = ROUND.replace("rings = 5; sides = 12; layers = 2", "rings = 3; sides = 8") + OF_27_NODES
MESHES = [LATTICE, ROUND, BRICKS, BENT]


def scene(mesh=LATTICE, cuts=1, orders="", end=END):
    mesh = mesh if "made of" in mesh else f"{mesh}; made of elements"
    text = GEL + BODY.replace("MESH", mesh)
    return text + "script {\n" + orders + UNUSED * cuts + "}\n" + end


BLADES = [
    ((11.2, 5, 5), (1, 0, 0.2)),
    ((10, 5, 5), (1, 0, 0)),  # in faces
    ((11, 5, 5), (0.3, 1, -0.4)),
    ((10, 5, 5), (1, 1, 1)),  # through nodes
    ((10, 5, 5), (0.2, 0.1, 1)),
]


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize("blade", BLADES)
def test_mass_volume_and_motion_are_kept(mesh, blade):
    """All are sums of as many numbers as there are nodes, to rounding."""
    state = state_of(scene(mesh, cuts=2))
    rng = np.random.default_rng(3)
    for through, facing in (blade, ((10.3, 4.4, 5.2), (0.1, 1, 0.3))):
        state.velocity[:] = 0.01 * rng.normal(size=state.velocity.shape)
        state.follow_hosts()
        before = state.inertia.sum(), volume(state), momentum(state)
        division = cut(state, through, facing)
        assert division is not None and len(division.copies)
        assert state.inertia.sum() == pytest.approx(before[0], rel=1e-14)
        assert volume(state) == pytest.approx(before[1], rel=1e-12)
        scale = np.abs(before[2]).max()
        assert_allclose(momentum(state), before[2], atol=1e-13 * scale, rtol=1e-12)
        assert (state.inertia[state.free] > 0.0).all()


@pytest.mark.parametrize("mesh", [LATTICE, BRICKS])
def test_the_area_is_that_of_the_section(mesh):
    state = state_of(scene(mesh))
    division = cut(state, (11.2, 5, 5), (1, 0, 0.2))
    expected = 100e-6 * np.sqrt(1.04)
    areas = division.triangles.sizes(division.body.parts, state.network.position)
    assert areas.sum() == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize("blade", BLADES)
def test_each_side_passes_the_patch_test(mesh, blade):
    """Under strains whose stress leaves the cut free, no node inside of a side has a force.

    Each side is strained on its own; stiffnesses are those at rest, so that forces are linear.
    In cells that are no boxes the surface of the cut is no plane, so that only nodes beside the
    cells that it divides are free.
    """
    state = state_of(scene(mesh))
    normal = np.array(blade[1], float) / np.linalg.norm(blade[1])
    assert cut(state, *blade) is not None
    place = state.network.position
    ahead = ahead_of(state, blade[0], normal)
    shear, bulk = 10e3 / 2.6, 10e3 / 1.2
    rng, across = np.random.default_rng(5), np.eye(3) - np.outer(normal, normal)
    moved = np.zeros_like(place)
    for side in (ahead, ~ahead):
        stress = rng.normal(size=(3, 3))
        stress = across @ (stress + stress.T) @ across
        mean = np.trace(stress) / 3.0
        strain = (stress - mean * np.eye(3)) / (2.0 * shear) + mean / (3.0 * bulk) * np.eye(3)
        turn = 1e-4 * rng.normal(size=(3, 3))
        moved[side] = place[side] @ (strain + turn - turn.T).T
    force = np.zeros_like(place)
    for each in state.elements:
        own = each.intact(state.alive)
        if own.item_count:
            stiff = own.element_matrices(place, exact=True)
            np.add.at(force, own.nodes, np.einsum("eaxby,eby->eax", stiff, moved[own.nodes]))
    skin = np.unique(state.network.skin)
    outer = np.isin(state.network.parents, skin)
    if mesh in (ROUND, BENT):
        for each in state.cut_elements:
            outer[each.nodes] = True
    assert np.abs(force[~outer]).max() < 1e-12 * np.abs(force[outer]).max()


@pytest.mark.parametrize(("radius", "off", "drawn"), [(5, 0.053, 3e-3), (20, 0.0094, 1e-3)])
def test_bent_hexahedra_are_cut_beside_the_blade(radius, off, drawn):
    """By as much of an element as the documentation says; mass and volume are kept."""
    state = state_of(scene(BRICKS.replace("20, 10, 10", "40, 10, 10"), cuts=1))
    around, (x, y, z) = radius * 5e-3, state.network.position.T
    out = around - z + 5e-3
    bent = [out * np.sin(x / around), y, around - out * np.cos(x / around)]
    state.position = np.stack(bent, axis=1)
    before = state.inertia.sum(), volume(state)
    through, normal = np.array([17.0, 5.0, 6.0]), np.array([1.0, 0.2, 0.6]) / np.sqrt(1.4)
    assert cut(state, through, normal) is not None
    assert (state.inertia.sum(), volume(state)) == pytest.approx(before, rel=1e-12)
    cells = state.cut_cells
    places = cells.points.beside(state.position)
    own = state.alive[cells.borders] & (cells.cuts != 0)
    high = (places[cells.triangles[own]] - 1e-3 * through) @ normal
    assert 0.5 * off < np.abs(high).max() / 5e-3 < off
    a, b, c, d = places[cells.corners[state.alive[cells.owners]]].swapaxes(0, 1)
    content = np.einsum("tx,tx->", np.cross(b - a, c - a), d - a) / 6.0
    (parts,) = (each.intact(state.alive) for each in state.elements if each.is_cut)
    ratio = np.linalg.det(parts.deformations(state.position))
    assert content == pytest.approx((parts.weights * ratio).sum(), rel=drawn)


def test_pieces_part_and_move_on_their_own():
    """Both halves keep the velocity of their nodes; no force is between them."""
    orders = "at 0 s: cut block along plane through (11.2, 0, 0) mm facing (1, 0, 0.2)\n"
    end = """output { count(pieces of block) every 1 ms; trajectory every 1 ms }
    simulate { duration = 4 ms }
    """
    text = scene(cuts=0, orders=orders, end=end)
    text = text.replace("tissue is gel }", "tissue is gel; velocity = (1, 0, 0) m/s }")
    played = play(text)
    assert played.log("pieces of block")[1][-1, 0] == 2
    nodes = played.position.shape[1]
    assert_allclose(
        played.position[-1] - played.position[0], [[4e-3, 0, 0]] * nodes, atol=1e-12
    )


@pytest.mark.parametrize("mesh", [LATTICE, BRICKS])
def test_halves_are_held_by_their_own_nodes(mesh):
    """The half beyond the held face is free, and falls as all that is free does."""
    orders = (
        "at 0 s: { fix base; cut block along plane through (11.2, 0, 0) mm facing (1, 0, 0) }\n"
    )
    end = (
        "output { position(tip) every 1 ms }\nsimulate { duration = 10 ms; tolerance = 1e-8 }\n"
    )
    text = scene(mesh, cuts=0, orders=orders, end=end)
    text = text.replace("(0, 0, 0) m/s^2", "(0, 0, -10) m/s^2")
    text = text.replace(
        "environment", "set tip = nodes of block where x > 12.6 mm\nenvironment"
    )
    played = play(text)
    time, place = played.log("position of tip")
    assert_allclose(place[:, 2] - place[0, 2], -5.0 * time**2, atol=1e-9)


def test_a_held_face_is_held_on_both_sides_of_a_cut():
    """Nodes that copies are of are held, and so are the copies; nothing falls off."""
    orders = (
        "at 0 s: { fix base; cut block along plane through (0, 5.3, 0) mm facing (0, 1, 0) }\n"
    )
    text = scene(cuts=0, orders=orders)
    compiled = compiled_scene(text)
    state = compiled.plan.start(compiled.network)
    base = compiled.nodes_of("base")
    state.holders["fix"] = base
    division = cut(state, (0, 5.3, 0), (0, 1, 0))
    held = state.holders["fix"]
    of_base = np.isin(state.network.parents[division.copies], base)
    assert of_base.any()
    assert set(division.copies[of_base]) == set(held) - set(base)


def test_a_load_on_copied_nodes_stays_the_same():
    """Forces of nodes are shared by their copies as their masses are."""
    text = scene(orders="at 0 s: push base with (1, 2, 3) mN\n")
    compiled = compiled_scene(text)
    state = compiled.plan.start(compiled.network)
    compiled.plan.events[0].action.apply(state, Diary())
    (load,) = state.loads.values()
    before = load.at(0.0)
    cut(state, (0, 5.3, 0), (0, 1, 0.1))
    (load,) = state.loads.values()
    assert len(load.nodes) > len(before)
    assert_allclose(load.at(0.0).sum(axis=0), before.sum(axis=0), rtol=1e-14)
    parents = state.network.parents[load.nodes]
    at_nodes = np.zeros((len(state.position), 3))
    np.add.at(at_nodes, parents, load.at(0.0))
    assert_allclose(at_nodes[compiled.nodes_of("base")], before, rtol=1e-13)


SLIT = (
    "at 0 s: fix base\n"
    "from 2 ms to 6 ms: cut block along line from (11.2, -1, 0) mm to (11.2, 6, 0) mm "
    "facing (1, 0, 0) using constant speed\n"
    "at 8 ms: cut block along plane through (5, 5, 0) mm facing (0, 1, 0.1)\n"
)
LOGGED = """output { trajectory every 1 ms; force of base every 1 ms; energy every 1 ms
  count(pieces of block) every 1 ms }
simulate { duration = 10 ms; tolerance = 1e-4 }
"""
SMALL = "lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 5) mm }"


def slit(mesh=SMALL):
    text = scene(mesh, 0, SLIT, LOGGED)
    return text.replace("(0, 0, 0) m/s^2", "(2, 0, -9.81) m/s^2")


def test_a_slit_leaves_one_piece_and_a_second_cut_crosses_it():
    played = play(slit("lattice { cell = 2.5 mm; box from (0, 0, 0) mm to (20, 10, 5) mm }"))
    time, pieces = played.log("pieces of block")
    assert set(pieces[time < 7.5e-3, 0]) == {1.0}
    # The slit ends at 6 mm, above the second cut, so that both its sides come off.
    assert pieces[-1, 0] == 3


def test_more_blades_than_there_are_nodes_for_end_the_run():
    state = state_of(scene())
    cut(state, (11.2, 5, 5), (1, 0, 0))
    with pytest.raises(NotDivisible, match="more blades meet at node"):
        cut(state, (11.3, 5, 5), (0, 1, 0.3))


MIRRORED = """body block {
  mesh is lattice { cell = 2.5 mm; box from (0, LOW, 0) mm to (10, 5, 5) mm }
  tissue is gel
}
set base = nodes of block where x < 0.01 mm
environment { gravity = (2, 0, -9.81) m/s^2; PLANE }
script { at 0 s: fix base
  at 1 ms: cut block along plane through (0, 0, 2.4) mm facing (0.1, 0, 1) }
simulate { duration = 5 ms; tolerance = 1e-6 }
output { force of base every 1 ms }
"""


def test_a_plane_of_symmetry_holds_copies_of_its_nodes():
    """The half bears half of the force of the whole; both runs are within the tolerance."""
    plane = "symmetric about plane through (0, 0, 0) mm facing (0, -1, 0)"
    half = play(GEL + MIRRORED.replace("LOW", "0").replace("PLANE", plane))
    whole = play(GEL + MIRRORED.replace("LOW", "-5").replace("PLANE", ""))
    found, expected = (each.log("force of base")[1][:, [0, 2]] for each in (half, whole))
    assert_allclose(2.0 * found, expected, atol=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize("mesh", [LATTICE, BRICKS])
def test_the_faces_of_a_cut_close_every_part(mesh):
    """Outward areas of the surface of each part that is drawn add up to nothing."""
    state = state_of(scene(mesh, cuts=2))
    cut(state, (11.2, 5, 5), (1, 0, 0.2))
    cut(state, (11.2, 5.2, 5), (0.1, 1, 0.3))
    drawn, place = state.cut_cells, state.position
    places = drawn.points.beside(place)
    a, b, c, d = places[drawn.corners].swapaxes(0, 1)
    volumes = np.einsum("tx,tx->t", np.cross(b - a, c - a), d - a) / 6.0
    assert (volumes > 0.0).all()
    alive = state.alive[drawn.owners]
    whole = sum(
        each.intact(state.alive).volume.sum() for each in state.elements if not each.is_cut
    )
    assert volumes[alive].sum() + whole == pytest.approx(2000e-9, rel=1e-12)
    cut_area = 0.0
    for part in np.unique(drawn.borders[state.alive[drawn.borders]]):
        own = drawn.borders == part
        p, q, r = places[drawn.triangles[own & (drawn.cuts != 0)]].swapaxes(0, 1)
        cut_area += 0.5 * np.linalg.norm(np.cross(q - p, r - p), axis=1).sum()
    first = 100e-6 * np.sqrt(1.04)
    second = 200e-6 * np.sqrt(1.1)
    assert cut_area == pytest.approx(2.0 * (first + second), rel=1e-9)


def test_the_gap_is_that_of_faces():
    """Halves that are moved apart by a millimetre have a gap of as much."""
    text = scene().replace(
        "environment", "set all = nodes of block where x >= 0 mm\nenvironment"
    )
    compiled = compiled_scene(text)
    state = compiled.plan.start(compiled.network)
    cut(state, (11.2, 5, 5), (1, 0, 0))
    snapshot = Snapshot.of(state)
    gap, subject = MEASURES["gap"], Subject("all", compiled.nodes_of("all"), ())
    assert gap.sample((subject,), snapshot)[0] == pytest.approx(0.0, abs=1e-12)
    ahead = snapshot.pieces == snapshot.pieces[state.position[:, 0].argmax()]
    state.position[ahead, 0] += 1e-3
    assert gap.sample((subject,), Snapshot.of(state))[0] == pytest.approx(1e-3, rel=1e-9)


def test_phantoms_of_glued_nodes_are_embedded_where_these_are():
    # Node 2 hangs between 0 and 5, node 7 on 5; phantoms 1, 4 and 6 are of 2, 7 and 0.
    glued = EmbeddedNodes(
        nodes=np.array([2, 7]), first=np.array([0, 2, 3]), hosts=np.array([0, 5, 5]),
        weights=np.array([1.25, -0.25, 1.0]), shares=np.array([0.75, 0.25, 1.0]),
    )  # fmt: skip
    joined = glued.joined_with(EmbeddedNodes.alone(np.array([1, 4, 6]), np.array([2, 7, 0])))
    assert joined.nodes.tolist() == [1, 2, 4, 6, 7]
    assert joined.first.tolist() == [0, 2, 4, 5, 6, 7]
    assert joined.hosts.tolist() == [0, 5, 0, 5, 5, 0, 5]
    assert joined.weights.tolist() == [1.25, -0.25, 1.25, -0.25, 1.0, 1.0, 1.0]
    assert joined.shares.tolist() == [0.75, 0.25, 0.75, 0.25, 1.0, 1.0, 1.0]
