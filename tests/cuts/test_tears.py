"""Solids that tear by faces: where tears go, what they take, and what is left."""

import numpy as np
import pytest

from tests.contact.scenes import play
from tests.cuts.scenes import begun, sections, volume
from tests.validate.scenes import compiled_scene, same_motion
from tests.whole_runs import same_on_two_threads, same_when_resumed
from tissuec.core.errors import CompileError
from tissuec.core.structs import replace
from tissuec.engine.failures import overloaded
from tissuec.forces.solids.ties import FAR
from tissuec.mechanics.tearing import set_limits
from tissuec.model.topology import pieces
from tissuec.script.breaking import break_apart

PLATE = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 1 ms; LIMIT }
body plate {
  mesh is MESH
  made of elements; tissue is gel; rupture by faces
}
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: cut plate along line from (-1, 10.3, 0) mm to (5.2, 10.3, 0) mm facing (0, 1, 0)
}
simulate { duration = 1 s }
"""
LATTICE = "lattice { cell = 2 mm; box from (0, 0, 0) mm to (30, 20, 2) mm }"
TOUGH = 1.0


def plate(limit=f"toughness = {TOUGH} J/m^2", made="elements"):
    text = PLATE.replace("made of elements", f"made of {made}")
    return begun(text.replace("LIMIT", limit).replace("MESH", LATTICE))


def stretched(state, degrees, strain):
    """Stretch all nodes evenly in the plane, along a direction from the y axis."""
    angle = np.deg2rad(degrees)
    along = np.array([-np.sin(angle), np.cos(angle), 0.0])
    shape = np.eye(3) + strain * np.outer(along, along)
    state.position[:] = state.network.position @ shape
    state.follow_hosts()
    return along


def opened(state, times=30):
    """Let faces go on through an even field, whose ties count as soft all the time."""
    for _ in range(times):
        tied = state.tied["plate"]
        state.tied = {"plate": replace(tied, softens=np.ones(len(tied), dtype=bool))}
        set_limits(state, "plate")
        entities = np.concatenate([one.walls for one in state.elements if not one.is_cut])
        broken = np.intersect1d(overloaded(state), entities)
        if not len(broken):
            break
        break_apart(state, broken)


@pytest.mark.parametrize(
    ("degrees", "made"),
    [*((each, "elements") for each in (0, 15, 30, 45)), (30, "quadratic elements")],
)
def test_tears_go_across_the_largest_stretch(degrees, made):
    """Within 10° at any angle to the mesh, and no tissue is lost.

    In an even field, every element has the same direction; the least height of nodes above the
    surface turns single sections.
    """
    state = plate(made=made)
    before = volume(state)
    along = stretched(state, degrees, 0.15)
    opened(state)
    middle, area, normal = sections(state)
    new = middle[:, 0] > 8e-3
    assert area[new].sum() > 2 * 2e-3 * 8e-3
    mean = (area[new, None] * normal[new] * np.sign(normal[new, 1:2])).sum(axis=0)
    cosine = mean @ along / np.linalg.norm(mean)
    assert np.degrees(np.arccos(min(cosine, 1.0))) < 3.0
    each = np.degrees(np.arccos(np.clip(np.abs(normal[new] @ along), 0.0, 1.0)))
    assert area[new] @ each / area[new].sum() < 10.0
    assert volume(state) == pytest.approx(before, rel=1e-12)
    assert state.inertia.sum() == pytest.approx(1000.0 * before, rel=1e-12)


def test_a_tear_through_the_whole_mesh_leaves_two_pieces():
    """Sections adjoin: their area is that of one surface."""
    state = plate()
    stretched(state, 0, 0.15)
    opened(state)
    _, area, _ = sections(state)
    assert area.sum() == pytest.approx(2 * 30e-3 * 2e-3, rel=2e-2)
    pairs = state.joined_pairs
    state.tied = {}
    left = [one for one in state.blocks.values() if one.kind == "ties"]
    state.remove(*left)
    used = np.unique(pairs)
    number = pieces(state.network.node_count, state.joined_pairs)[used]
    assert len(np.unique(number)) == 2


def one_point(state):
    """Return a point of a tear, and displacements of nodes [m] that open it by 1 m."""
    (field,) = state.of_kind("ties")
    own = field.only(np.flatnonzero(field.first < FAR)[:1])
    half = own.nodes.shape[1] // 2
    only = np.setdiff1d(own.nodes[0, :half], own.nodes[0, half:])
    way = np.zeros_like(state.position)
    way[only] = [0.0, 1.0 / own.weights[0, np.isin(own.nodes[0], only)].sum(), 0.0]
    return own, way


def test_faces_take_the_toughness_as_they_open():
    """Traction times opening, from 0 to the opening at which they are free, is G per area."""
    state = plate()
    own, way = one_point(state)
    first, last = own.first[0], own.last[0]
    knots = np.concatenate([np.linspace(0, first, 41), np.linspace(first, last, 401)[1:]])
    still, work, stored = np.zeros_like(state.velocity), [], []
    for opening in knots:
        forces = np.zeros_like(state.position)
        there = state.position + opening * way
        own.add_forces(0.0, there, still, forces)
        work.append(-(forces * way).sum())
        stored.append(own.energy(0.0, there))
    tied = state.tied["plate"]
    share = own.stiffness[0] / tied.stiffness[0]  # its area
    assert np.trapezoid(work, knots) == pytest.approx(TOUGH * share, rel=1e-9)
    assert stored[-1] == pytest.approx(TOUGH * share, rel=1e-12)
    size = 2e-3
    strength = np.sqrt(9 * np.pi / 32 * 10e3 / 0.91 * TOUGH / (3 * size))
    assert max(work) == pytest.approx(strength * share, rel=1e-9)
    assert last == pytest.approx(2.0 * TOUGH / strength, rel=1e-12)
    beyond = state.position + 1.5 * last * way
    forces = np.zeros_like(state.position)
    own.add_forces(0.0, beyond, still, forces)
    assert np.abs(forces).max() == 0.0


def test_viscosity_hardly_resists_faces_that_open():
    """Ties that soften lose their damping d: at a speed s, it takes 4/3 d s g₀ per area.

    Of the share (g₁ - g)/(g₁ - g₀) g₀/g to the fourth power, 1/3 is left beyond g₀ if g₁ is
    far larger.
    """
    state = plate()
    own, way = one_point(state)
    first, last = own.first[0], own.last[0]
    knots = np.concatenate([np.linspace(0, first, 3), np.geomspace(first, last, 401)[1:]])
    power = []
    for opening in knots:
        forces, still = np.zeros_like(state.position), np.zeros_like(state.position)
        there = state.position + opening * way
        own.add_forces(0.0, there, way, forces)
        own.add_forces(0.0, there, still, back := np.zeros_like(forces))
        power.append(((back - forces) * way).sum())
    assert own.damping[0] > 0.0
    ratio = last / first
    reach = np.geomspace(1.0, ratio, 401)
    expected = 1.0 + np.trapezoid(((ratio - reach) / (ratio - 1.0) / reach) ** 4, reach)
    assert 1.2 < expected < 4 / 3
    lost = np.trapezoid(power, knots)
    assert lost == pytest.approx(expected * own.damping[0] * first, rel=1e-3)


def test_small_sections_take_the_toughness_too():
    """Their ties are soft: at the strength of others, they would be free before they soften."""
    state = plate()
    stretched(state, 30, 0.15)
    opened(state)
    tied = state.tied["plate"]
    tears = np.isfinite(tied.first)
    first, last, stiffness = tied.first[tears], tied.last[tears], tied.stiffness[tears]
    assert (last / first).min() == pytest.approx(4.0)
    assert (stiffness * first * last / 2.0) == pytest.approx(TOUGH, rel=1e-12)
    usual = first * stiffness == (first * stiffness).max()
    assert 0 < np.count_nonzero(~usual) < 0.1 * len(usual)
    assert tied.is_gradual[tears].all()


def test_elements_are_divided_near_what_softens_alone():
    """Ties that stay whole would make tissue softer: by M/(k H) along all of its height H."""
    state = plate()
    stretched(state, 0, 0.15)  # all that is ahead bears its strength
    opened(state, times=1)
    tied = state.tied["plate"]
    middle = tied.values(state.cut_bodies["plate"], state.network.position)[:, 0].mean(axis=1)
    # The end of the notch softens, in the element up to 6 mm; others are around 7, 9, … mm.
    assert middle[:, 0].max() < 6e-3 + 2.5 * 2e-3
    assert middle[:, 0].max() > 8e-3


def test_tissue_with_a_strain_tears_at_once():
    state = plate("breaking strain = 10 %")
    stretched(state, 0, 0.11)
    parted = set()
    for _ in range(20):
        broken = overloaded(state)
        if not len(broken):
            break
        parted |= set(break_apart(state, broken).entities.tolist())
    assert len(parted) == 12  # from the notch, which ends in the third of 15 elements, on
    assert len(state.tied["plate"]) < 20  # the element in which the notch ends


STRIP = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 1 ms; toughness = 0.2 J/m^2 }
body plate {
  mesh is lattice { cell = 4 mm; box from (0, 0, 0) mm to (24, 16, 4) mm }
  made of elements; tissue is gel; rupture by faces
}
set low = nodes of plate where y < 0.001 mm
set high = nodes of plate where y > 15.999 mm
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix low
  at 0 s: cut plate along line from (-1, 8.9, 0) mm to (11, 8.9, 0) mm facing (0, 1, 0)
  from 0 s to 50 ms: move high by (0, 2.4, 0) mm using constant speed
}
simulate { duration = 50 ms; tolerance = 1e-5 }
output { force of high every 1 ms; energy every 1 ms; ruptured(plate) every 1 ms
  count(pieces of plate) every 1 ms; trajectory every 10 ms }
"""


def test_energy_that_faces_take_is_in_the_ledger():
    """The strip comes apart: what was switched is the toughness times the area of the faces."""
    played = play(STRIP)
    assert played.log("pieces of plate")[1][-1, 0] == 2
    _, energy = played.energies()
    stored = energy["kinetic"] + energy["elastic"]
    gap = stored - (energy["work"] - energy["dissipated"] + energy["switched"])
    assert np.abs(gap).max() < 1e-3 * energy["work"].max()
    assert -energy["switched"][-1] == pytest.approx(0.2 * 13e-3 * 4e-3, rel=0.02)
    _, size, _ = sections(played.outcome.state)  # of both sides, and of the notch
    torn = 0.5 * size.sum() - 11e-3 * 4e-3
    assert -energy["switched"][-1] == pytest.approx(0.2 * torn, rel=1e-4)
    events = [one for _, one in played.outcome.logged_events if one.kind == "rupture"]
    assert sum(len(one.springs) for one in events) >= 4
    assert all("have opened" in one.cause for one in events)


@pytest.mark.slow
def test_a_strip_tears_in_equilibrium():
    """The work is that of the faces, and what a jump to another equilibrium releases."""
    text = STRIP.replace("; tolerance = 1e-5", "; integrator is equilibrium")
    played = play(text.replace("every 1 ms", "every 2 ms"))
    assert played.log("pieces of plate")[1][-1, 0] == 2
    _, energy = played.energies()
    expected = 0.2 * 13e-3 * 4e-3
    assert -energy["switched"][-1] == pytest.approx(expected, rel=0.02)
    assert energy["work"][-1] == pytest.approx(expected, rel=0.05)
    assert abs(energy["elastic"][-1]) < 1e-9 * expected


@pytest.mark.slow
def test_scipy_finds_the_same_tear():
    text = STRIP.replace("tolerance = 1e-5", "tolerance = 1e-4")
    same_motion(text.replace("duration = 50 ms", "duration = 7.5 ms"), within=1e-3)


def test_a_run_that_is_resumed_within_a_tear_gives_the_same_bytes():
    _, *parts = same_when_resumed(compiled_scene(STRIP), "force of high", 8, 12)
    assert any(first.state.tears for first, _ in parts)


@pytest.mark.slow
def test_threads_change_no_bit(threads_in_small_nets):
    text = STRIP.replace("cell = 4 mm", "cell = 2 mm").replace("(24, 16, 4)", "(24, 16, 8)")
    run = same_on_two_threads(compiled_scene(text.replace("50 ms", "8 ms")), "force of high")
    assert run.state.tears["plate"].torn[0].sum() > 4


def test_walls_do_not_tear_by_faces():
    text = PLATE.replace("LIMIT", "breaking strain = 10 %").replace(
        "MESH",
        "sheet { corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; columns = 5; rows = 5\n"
        "second edge = (0, 20, 0) mm }; thickness = 1 mm",
    )
    with pytest.raises(CompileError, match="only solids of elements"):
        compiled_scene(text)
