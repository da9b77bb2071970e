"""Interfaces with a toughness: how stiff they are, what peeling takes, and what is left."""

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from tests.contact.scenes import gap_of_balance, play
from tests.cuts.scenes import (
    ALONG_ARMS,
    PULLED,
    begun,
    peel_of_arms,
    state_of,
    tied_area,
    volume,
)
from tests.every import every
from tests.hand_net import Diary
from tests.validate.scenes import compiled_scene, same_motion
from tests.whole_runs import same_on_two_threads, same_when_resumed
from tissuec.analysis.bodies import properties_of
from tissuec.core.errors import CompileError
from tissuec.learn.derivatives.refusals import refusal_of_script
from tissuec.model.topology import pieces

TOUGH = 0.2  # J/m²
GEL = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 1 ms; cutting resistance = 30 J/m^2 }
tissue stiff { Young's modulus = 40 kPa; Poisson's ratio = 0.3; density = 2000 kg/m^3 }
"""
STRIP = (
    GEL
    + """body strip {
  mesh is lattice { cell = 2 mm; box from (0, 0, 0) mm to (24, 4, 8) mm }
  tissue is gel
  region upper where z > 4 mm { tissue is gel }
  interface from strip to upper { toughness = 0.2 J/m^2 }
}
set top = nodes of strip where z > 7.9 mm
set base = nodes of strip where z < 0.1 mm
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix base
  from 0 s to 40 ms: move top by (0, 0, 3) mm using constant speed
}
simulate { duration = 40 ms; tolerance = 1e-4 }
output { force of top every 1 ms; energy every 1 ms; trajectory every 10 ms
  ruptured(strip) every 1 ms; count(pieces of strip) every 1 ms
  face area(cut faces of strip) every 1 ms; gap(strip) every 1 ms }
"""
)
BLOCK = (
    GEL
    + """body block {
  mesh is MESH
  made of elements; tissue is gel
PARTS
}
environment { gravity = (0, 0, 0) m/s^2 }
script { }
simulate { duration = 1 s }
"""
)
LATTICE = "lattice { cell = 2 mm; box from (0, 0, 0) mm to (12, 12, 12) mm }"
TUBE = (
    "thick tube { axis from (0, 0, 0) mm to (12, 0, 0) mm; inner radius = 4 mm\n"
    "  outer radius = 8 mm; rings = 4; sides = 12; layers = 2 }"
)
BETWEEN = "interface from {} to {} {{ toughness = 1 J/m^2 }}\n"
UPPER = "region a where z > 6 mm { tissue is stiff }\n"


def block(parts, mesh=LATTICE):
    return state_of(BLOCK.replace("MESH", mesh).replace("PARTS", parts))


def masses(state):
    """Return the masses of what holds together without ties [kg], ascending."""
    state.remove(*(each for each in state.blocks.values() if each.kind == "ties"))
    pairs = state.joined_pairs
    used = np.unique(pairs)
    _, number = np.unique(pieces(len(state.position), pairs)[used], return_inverse=True)
    return np.sort(np.bincount(number, state.inertia[used]))


# --- as drawn ---------------------------------------------------------------------------------

IN_A = "x between 4 mm and 8 mm and y between 4 mm and 8 mm and z between 4 mm and 8 mm"
CASES = {
    "two layers": (LATTICE, UPPER + BETWEEN.format("a", "block"), 144.0, [0.864, 1.728]),
    "an inclusion": (
        LATTICE, f"region a where {IN_A} {{ tissue is stiff }}\n"
        + BETWEEN.format("block", "a"),
        96.0, [0.128, 1.664],
    ),
    "a layer of one cell": (
        LATTICE,
        "region a where z between 4 mm and 6 mm { tissue is stiff }\n"
        + BETWEEN.format("a", "block"),
        288.0, [0.576, 0.576, 0.864],
    ),
    "three regions": (
        LATTICE,
        UPPER + "region b where z < 6 mm and x < 6 mm { tissue is stiff }\n"
        + BETWEEN.format("a", "block") + BETWEEN.format("b", "a")
        + BETWEEN.format("b", "block"),
        216.0, [0.432, 0.864, 1.728],
    ),
    "four columns": (
        LATTICE,
        "region a where (x < 6 mm and y < 6 mm) or (x > 6 mm and y > 6 mm) "
        "{ tissue is stiff }\n"
        + BETWEEN.format("a", "block"),
        288.0, [0.432, 0.432, 0.864, 0.864],
    ),
    "wedges": (
        TUBE,
        "region a where x > 6 mm { tissue is stiff }\n" + BETWEEN.format("a", "block"),
        150.7964, [0.904779, 1.809557],
    ),
}  # fmt: skip


@every("case", CASES)
def test_regions_come_apart_with_their_own_mass(case):
    """Areas are those of the faces, and pieces have the densities of their regions."""
    mesh, parts, area, expected = CASES[case]
    state = block(parts, mesh)
    assert tied_area(state, "block") == pytest.approx(1e-6 * area, rel=1e-6)
    network = state.network
    drawn = network.mass[network.parents == np.arange(network.node_count)].sum()
    assert state.inertia.sum() == pytest.approx(drawn, rel=1e-12)
    assert volume(state) == pytest.approx(
        sum(e.volume.sum() for e in network.elements), rel=1e-12
    )
    assert masses(state) == pytest.approx(1e-3 * np.array(expected), rel=1e-6)


def test_other_regions_hold_both_together_at_the_rim():
    """Where a third region adjoins, nodes of the interface are common, and nothing parts."""
    third = "region b where x < 6 mm { tissue is gel }\nregion a where z > 6 mm and x > 6 mm "
    state = block(third + "{ tissue is gel }\n" + BETWEEN.format("a", "block"))
    assert tied_area(state, "block") == pytest.approx(72e-6, rel=1e-12)
    assert len(masses(state)) == 1


@pytest.mark.parametrize("cell", [2, 1])
def test_ties_are_a_twentieth_of_the_compliance_of_two_cells(cell):
    """Small tension without contraction: H/E and 1/k = h/10E in series."""
    text = STRIP.replace("Poisson's ratio = 0.3", "Poisson's ratio = 0")
    text = text.replace("cell = 2 mm", f"cell = {cell} mm").replace("(24, 4, 8)", "(4, 4, 8)")
    state = state_of(text)
    place, count = state.network.position, state.network.node_count
    fields = [each for each in state.fields if hasattr(each, "element_matrices")]
    stiff = sum(each.matrix(0.0, place, np.arange(count), count) for each in fields).tocsr()
    moved, known = np.zeros_like(place), np.zeros_like(place, dtype=bool)
    low, high = place[:, 2] < 1e-9, place[:, 2] > 8e-3 - 1e-9
    known[:, :2] = known[low | high | ~state.free] = True
    moved[high, 2] = 1e-6
    known, moved = known.ravel(), moved.ravel()
    moved[~known] = spsolve(stiff[~known][:, ~known], -(stiff[~known] @ moved))
    found = moved @ (stiff @ moved) / 1e-12
    expected = 10e3 * 16e-6 / (8e-3 + cell * 1e-3 / 10.0)
    assert found == pytest.approx(expected, rel=1e-9)


def test_sets_are_on_their_own_side_of_an_interface():
    """Regions end there; nodes on it alone, and of both layers, are on both sides."""
    state = block(UPPER + BETWEEN.format("a", "block"))
    z = state.network.position[:, 2]
    parents = state.network.parents
    drawn = np.flatnonzero(parents == np.arange(len(parents)))
    used = np.zeros(len(z), dtype=bool)
    for side, sign in ((z >= 6e-3 - 1e-9, 1.0), (z <= 6e-3 + 1e-9, -1.0)):
        found = state.with_copies(drawn[side[drawn]])
        assert len(found) == 4 * 49
        parts = state.cut_bodies["block"].parts[0]
        own = sign * (z[parts.drawn].mean(axis=1) - 6e-3) > 0.0
        assert np.isin(found, parts.nodes[own]).all()
        assert not used[found].any()
        used[found] = True
    on = np.abs(z - 6e-3) < 1e-9
    assert len(state.with_copies(drawn[on[drawn]])) == 2 * 49
    end = state.network.position[:, 0] < 1e-9
    found = state.with_copies(drawn[end[drawn]])
    assert len(found) == 8 * 7
    assert (state.with_copies(found) == found).all()


def test_nodes_in_reserve_are_not_counted():
    (found,) = properties_of(compiled_scene(STRIP))
    assert found.nodes == 13 * 3 * 5


# --- peeling ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("made", "count"), [("elements", 24), ("quadratic elements", 6)])
def test_two_layers_part_for_the_toughness_of_their_interface(made, count):
    """The energy that is switched off is G times the area, to rounding; nothing is lost."""
    text = STRIP.replace("  region", f"  made of {made}\n  region")
    played = play(text if count == 24 else text.replace("cell = 2 mm", "cell = 4 mm"))
    state, (_, energy) = played.outcome.state, played.energies()
    assert played.log("pieces of strip")[1][-1, 0] == 2
    assert played.log("ruptured of strip")[1][-1, 0] == count  # elements on one side
    area = played.log("face area of cut faces of strip")[1]
    assert area[0, 0] == pytest.approx(0.0, abs=1e-15)
    assert area[-1, 0] == pytest.approx(2 * 96e-6, rel=1e-3)
    assert played.log("gap of strip")[1][-1, 0] > 2e-3
    assert -energy["switched"][-1] == pytest.approx(TOUGH * 96e-6, rel=1e-9)
    assert gap_of_balance(played) < 1e-5
    assert volume(state) == pytest.approx(24e-3 * 4e-3 * 8e-3, rel=1e-12)
    assert state.inertia.sum() == pytest.approx(1000.0 * 24e-3 * 4e-3 * 8e-3, rel=1e-12)
    events = [one for _, one in played.outcome.logged_events if one.kind == "rupture"]
    assert "the interface from strip to upper has opened (" in events[0].cause
    assert events[0].span.text.startswith("interface from strip to upper")


PEELED = (
    GEL.replace("10 kPa; Poisson's ratio = 0.3", "100 kPa; Poisson's ratio = 0")
    + """body strip {
  mesh is lattice { cell = CELL mm; box from (0, 0, 0) mm to (60, 4, 8) mm }
  tissue is gel
  region upper where z > 4 mm { tissue is gel }
  interface from strip to upper { toughness = 1 J/m^2 }
}
set top = nodes of strip where x < 0.1 mm and z > 7.9 mm
set low = nodes of strip where x < 0.1 mm and z < 0.1 mm
"""
    + ALONG_ARMS
    + """script {
  at 0 s: { fix low; cut strip along line from (-1, 0, 4) mm to (15, 0, 4) mm facing (0, 0, 1) }
"""
    + PULLED
)


@pytest.mark.slow
def test_two_beams_are_peeled_by_the_force_of_the_closed_form():
    """The interface opens element by element: the toughness is 1 J/m²."""
    assert peel_of_arms(play(PEELED.replace("CELL", "2"))) == pytest.approx(1.0, abs=0.1)


def test_layers_that_part_in_equilibrium_take_the_work_of_their_interface():
    """Between equilibria nothing is lost: both are pulled apart evenly, without a jump."""
    text = STRIP.replace("(24, 4, 8)", "(8, 4, 8)").replace("every 1 ms", "every 2 ms")
    played = play(text.replace("; tolerance = 1e-4", "; integrator is equilibrium"))
    _, energy = played.energies()
    assert energy["work"][-1] == pytest.approx(TOUGH * 32e-6, rel=1e-9)
    assert abs(energy["elastic"][-1]) < 1e-12 * energy["work"][-1]


@pytest.mark.slow
def test_scipy_finds_the_same_peeling():
    text = STRIP.replace("(24, 4, 8)", "(8, 4, 8)")
    same_motion(text.replace("duration = 40 ms", "duration = 18 ms"), within=1e-3)


def test_a_run_that_is_resumed_while_it_peels_gives_the_same_bytes():
    text = STRIP.replace("(24, 4, 8)", "(12, 4, 8)")
    _, *parts = same_when_resumed(compiled_scene(text), "force of top", 5, 8)
    ties = [first.state.tied["strip"] for first, _ in parts]
    assert ties[0].softens.any() and 0 < len(ties[1]) < 24


@pytest.mark.slow
def test_threads_change_no_bit(threads_in_small_nets):
    text = STRIP.replace("cell = 2 mm", "cell = 1 mm")
    text = text.replace("duration = 40 ms", "duration = 13 ms")
    run = same_on_two_threads(compiled_scene(text), "force of top")
    assert any(one.kind == "rupture" for _, one in run.logged_events)


def test_learning_has_no_exact_derivatives_beside_an_interface():
    compiled = compiled_scene(STRIP)
    assert "interface" in refusal_of_script(compiled.plan, compiled.network)


# --- blades and tears -------------------------------------------------------------------------

ORDER = "cut block along line from (-1, 0, {z}) mm to (7, 0, {z}) mm facing (0, 0, 1)"


@pytest.mark.parametrize("off", [0.0, 0.15])
def test_a_blade_along_an_interface_frees_it(off):
    """Also up to a tenth of an element beside it; the event has its area."""
    text = BLOCK.replace("MESH", LATTICE).replace("PARTS", UPPER + BETWEEN.format("a", "block"))
    order = ORDER.format(z=6.0 + off)
    compiled = compiled_scene(text.replace("script { }", f"script {{ at 0 s: {order} }}"))
    state, queue = compiled.plan.start(compiled.network), Diary()
    (event,) = compiled.plan.events[0].action.apply(state, queue)
    assert tied_area(state, "block") == pytest.approx(5e-3 * 12e-3, rel=1e-9)
    assert "(84 mm^2, " in event.cause
    assert volume(state) == pytest.approx(12e-3**3, rel=1e-12)
    assert len(np.concatenate(state.cut_bodies["block"].entities)) == 6**3


def test_a_blade_across_an_interface_divides_it():
    text = BLOCK.replace("MESH", LATTICE).replace("PARTS", UPPER + BETWEEN.format("a", "block"))
    order = "cut block along plane through (5, 0, 6) mm facing (1, 0.1, 0.3)"
    state = begun(text.replace("script { }", f"script {{ at 0 s: {order} }}"))
    assert tied_area(state, "block") == pytest.approx(144e-6, rel=1e-9)
    assert len(masses(state)) == 4


def test_scissors_that_close_along_an_interface_free_it():
    text = BLOCK.replace("MESH", LATTICE).replace("PARTS", UPPER + BETWEEN.format("a", "block"))
    order = ORDER.format(z=6)
    compiled = compiled_scene(
        text.replace("script { }", f"script {{ from 0 s to 1 s: {order} }}")
    )
    state, diary = compiled.plan.start(compiled.network), Diary()
    compiled.plan.events[0].action.apply(state, diary)
    diary.play(state, 1.0)
    assert tied_area(state, "block") == pytest.approx(5e-3 * 12e-3, rel=1e-6)


@pytest.mark.slow
def test_a_scalpel_along_an_interface_needs_the_cutting_resistance():
    """30 J/m² times 10 mm; the front is three eighths of an element behind the edge."""
    text = (
        GEL.replace("10 kPa", "100 kPa").replace(
            "retardation time = 1 ms", "shear viscosity = 20 Pa*s"
        )
        + """body block {
  mesh is lattice { cell = 2.5 mm; box from (0, 0, 0) mm to (10, 10, 10) mm }
  tissue is gel
  region right where x > 5 mm { tissue is gel }
  interface from right to block { toughness = 20 J/m^2 }
}
set base = nodes of block where z == 0 mm
tool knife { kind is scalpel; edge from (5.1, -4, 10.3) mm to (5.1, 14, 10.3) mm }
environment { gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m }
script {
  at 0 s: fix base
  from 0 s to 40 ms: { cut block with knife; move knife by (0, 0, -4) mm using constant speed }
}
simulate { duration = 40 ms }
output { force(knife) every 1 ms }
"""
    )
    played = play(text)
    assert played.log("force of knife")[1][-6:-1, 2] == pytest.approx(-0.3, rel=5e-3)
    front = 4.0 - 0.3 - 0.375 * 2.5
    left = tied_area(played.outcome.state, "block")
    assert 100e-6 - left == pytest.approx(front * 1e-5, rel=0.3)


NOTCHED = (
    GEL.replace("cutting resistance = 30 J/m^2", "toughness = 0.2 J/m^2")
    + """body plate {
  mesh is lattice { cell = 4 mm; box from (0, 0, 0) mm to (24, 16, 4) mm }
  tissue is gel; rupture by faces
  region right where x > 12 mm { tissue is gel }
  interface from plate to right { toughness = 0.1 J/m^2 }
}
set low = nodes of plate where y < 0.001 mm
set high = nodes of plate where y > 15.999 mm
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix low
  at 0 s: cut plate along line from (-1, 8.9, 0) mm to (7, 8.9, 0) mm facing (0, 1, 0)
  from 0 s to 50 ms: move high by (0, 3.6, 0) mm using constant speed
}
simulate { duration = 50 ms; tolerance = 1e-4 }
output { force of high every 1 ms; energy every 1 ms; count(pieces of plate) every 1 ms }
"""
)


def test_a_tear_that_meets_an_interface_begins_anew_behind_it():
    """Energies of both are booked, and no tissue is lost."""
    played = play(NOTCHED)
    assert played.log("pieces of plate")[1][-1, 0] == 2
    causes = " ".join(one.cause for _, one in played.outcome.logged_events)
    assert "the interface from plate to right has opened" in causes
    assert "the faces in element" in causes
    assert gap_of_balance(played) < 1e-5
    assert volume(played.outcome.state) == pytest.approx(24e-3 * 16e-3 * 4e-3, rel=1e-12)


# --- what is refused --------------------------------------------------------------------------

PARTS = "region a where z > 6 mm { tissue is gel }\nregion b where z < 4 mm { tissue is gel }\n"
SHEET = (
    "sheet { corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 0, 12) mm\n"
    "columns = 5; rows = 9 }"
)
WRONG = [
    (PARTS + "interface from a to c { toughness = 1 J/m^2 }", LATTICE, "no region called"),
    (PARTS + BETWEEN.format("a", "b"), LATTICE, "have no face of elements in common"),
    (PARTS + BETWEEN.format("a", "a"), LATTICE, "have no face of elements in common"),
    (PARTS + "interface from a to block { toughness = -1 J/m^2 }", LATTICE, "must be above 0"),
    (PARTS + "interface from a to block { toughness = 1 J }", LATTICE, "but 1 J is an energy"),
    (
        PARTS + "interface from a to block { toughness = 1 J/m^2; tissue is gel }", LATTICE,
        "an interface of springs has a tissue, one of elements a toughness",
    ),
    (
        PARTS + "interface from a to block { toughness = 1 J/m^2; toughness = 2 J/m^2 }",
        LATTICE,
        '"toughness" is given twice',
    ),
    (
        PARTS + "interface from a to block { toughness = 1 J/m^2; density = 1 kg/m^3 }",
        LATTICE,
        "not allowed in an interface with a toughness",
    ),
    (
        PARTS + BETWEEN.format("a", "block") + BETWEEN.format("block", "a"), LATTICE,
        "is given twice",
    ),
    (
        PARTS + BETWEEN.format("a", "block") + "rupture is allowed", LATTICE,
        "cannot break as a whole",
    ),
    (
        PARTS + BETWEEN.format("a", "block") + "thickness = 1 mm", SHEET,
        "only regions of solids",
    ),
]  # fmt: skip


@every("wrong", WRONG)
def test_interfaces_that_cannot_come_apart_are_refused(wrong):
    parts, mesh, message = wrong
    with pytest.raises(CompileError, match=message):
        block(parts, mesh)


def test_springs_do_not_come_apart():
    text = BLOCK.replace("MESH", LATTICE).replace("PARTS", UPPER + BETWEEN.format("a", "block"))
    net = "gel { spring constant = 40 N/m; viscosity = 0.1 N*s/m; mass = 1 g }\ntissue ge {"
    text = text.replace("gel {", net).replace("made of elements", "interface is mean")
    text = text.replace("lattice {", "lattice { kind is sodium chloride;")
    text = text.replace("{ tissue is stiff }", "{ prestress = 1 % }")
    with pytest.raises(CompileError, match="only regions of solids of elements"):
        state_of(text)
