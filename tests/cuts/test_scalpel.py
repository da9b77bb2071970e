"""Scalpels: what they take to cut, where they cut, and what they leave."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import tissuec
from tests.contact.scenes import play
from tests.cuts.scenes import cut_faces, tied_area
from tests.validate.scenes import compiled_scene, validated
from tests.whole_runs import same_on_two_threads, same_when_resumed
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.forces.acting.cutting_edges import CuttingEdge
from tissuec.geometry.cut_cells.sections import facet_sizes
from tissuec.model.topology import pieces
from tissuec.pipeline import check_request
from tissuec.results.instruments.courses import courses, solids
from tissuec.results.moments import Moments
from tissuec.scene.request import Request
from tissuec.validate.forces.cutting_edges import PushingEdge

RESISTANCE, WIDTH = 50.0, 10e-3
#: Ends of the edge, and how it moves [mm], and its length over its width across the block.
DOWN = ((5.3, -4, 10.3), (5.3, 14, 10.3), (0, 0, -6), 1.0)
#: Oblique to the mesh, and with an edge that is not parallel to a face.
SKEW = ((3, -4, 12), (5, 14, 12), (1.5, 0, -7), np.hypot(1.0, 2.0 / 18.0))
SCENE = """language 1
tissue gel {{
  density = 1000 kg/m^3; Young's modulus = 100 kPa; Poisson's ratio = 0.3
  shear viscosity = 20 Pa*s; cutting resistance = {resistance} J/m^2
}}
body block {{
  mesh is lattice {{ cell = {cell} mm; box from (0, 0, 0) mm to (10, 10, 10) mm }}
  made of elements; tissue is gel
}}
set base = nodes of block where z < 0.01 mm
tool knife {{ kind is scalpel; edge from {start} mm to {stop} mm }}
environment {{ gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m }}
script {{
  at 0 s: fix base
  {orders}
}}
simulate {{ duration = {duration} ms }}
output {{ trajectory every 4 ms; force(knife) every 1 ms; energy every 1 ms }}
"""


def scene(way=DOWN, cell=2.5, orders="", duration=60, resistance=RESISTANCE):
    start, stop, by, _ = way
    own = "from 0 s to 60 ms: { cut block with knife; "
    own += f"move knife by {by} mm using constant speed }}"
    return SCENE.format(
        cell=cell, start=start, stop=stop, orders=orders or own, duration=duration,
        resistance=resistance,
    )  # fmt: skip


def felt(result, way):
    """Return times [s], and the force along the way [N] without what is along the edge."""
    found = result.logs["force of knife"]
    start, stop, by = (np.array(each, float) for each in way[:3])
    edge = stop - start
    ahead = by - by @ edge / (edge @ edge) * edge
    return np.array(found.time), np.array(found.value) @ (ahead / np.linalg.norm(ahead))


def cut_events(result):
    return [one for one in result.events if one.kind == "cut"]


@pytest.fixture(scope="module")
def run():
    known = {}

    def made(**options):
        key = tuple(sorted(options.items()))
        if key not in known:
            known[key] = tissuec.run(scene(**options), companion="off")
        return known[key]

    return made


MESHES = [2.5, 2.0, pytest.param(1.25, marks=pytest.mark.slow)]


@pytest.mark.parametrize("cell", MESHES)
@pytest.mark.parametrize("way", [DOWN, SKEW], ids=["down", "skew"])
def test_the_force_is_the_resistance_times_the_width(run, cell, way):
    """Each piece of the edge bears no more; widths are found by areas of strips, which leaves
    what strains of triangles do to them: 1e-3 with strains of some per cent.
    """
    time, force = felt(run(way=way, cell=cell), way)
    late = (time > 0.04) & (time < 0.0595)
    assert_allclose(force[late], RESISTANCE * WIDTH * way[3], rtol=1e-3)


def test_tissue_is_dented_before_it_is_cut(run):
    """The force rises with the way of the edge; nothing is cut until it is that of a cut."""
    result = run(way=DOWN, cell=2.5)
    time, force = felt(result, DOWN)
    areas = [one for one in cut_events(result) if "mm^2" in one.cause]
    first = areas[0].time
    dented = (time > 0.006) & (time < first)
    assert (np.diff(force[dented]) > 0.0).all() and dented.sum() > 4
    assert force[dented].max() < RESISTANCE * WIDTH * 1.001
    row = np.searchsorted(result.times, first) - 1
    depth = (result.position[row] - result.position[0])[:, 2].min()
    assert depth < -0.3e-3


def test_the_balance_of_energy_is_closed(run):
    """Work = stored + lost + spent, to the tolerance of the run; the edge spends F times its
    way through tissue, which is what events state but for what ties release (some 5 %).
    """
    result = run(way=DOWN, cell=2.0)
    kinetic, stored, _, work, lost, switched = np.array(result.energies.value)[-1]
    assert kinetic + stored == pytest.approx(work - lost + switched, abs=1e-3 * work)
    spent = sum(joules(one.cause) for one in cut_events(result) if "J)" in one.cause)
    assert spent == pytest.approx(-switched, rel=0.08)


def joules(cause):
    number, unit = cause.rstrip(")").split(", ")[-1].split()
    return float(number) * {"nJ": 1e-9, "uJ": 1e-6, "mJ": 1e-3}[unit]


@pytest.mark.parametrize("through", [7.5, 15.0])
def test_without_resistance_the_edge_cuts_what_it_passes(through):
    """The area is that of what the edge passes of the block, and the knife feels nothing."""
    orders = (
        "from 0 s to 60 ms: { cut block with knife; "
        f"move knife by (0, 0, -{through}) mm using constant speed }}"
    )
    played = play(scene(orders=orders, resistance=0.0))
    assert np.abs(played.log("force of knife")[1]).max() < 1e-6 * RESISTANCE * WIDTH
    state = played.outcome.state
    passed = min(through - 0.3, 10.0) * 10.0
    area = 0.5 * facet_sizes(cut_faces(state)).sum() - tied_area(state, "block")
    assert area == pytest.approx(1e-6 * passed, rel=1e-9)
    piece = pieces(state.network.node_count, state.joined_pairs)
    nodes = np.unique(np.concatenate([each.nodes[state.alive[each.walls]].ravel()
                                      for each in state.elements]))  # fmt: skip
    assert len(np.unique(piece[nodes])) == (2 if through > 10.0 else 1)


def test_a_push_below_the_resistance_only_dents():
    orders = (
        "from 0 s to 60 ms: { cut block with knife; "
        "move knife by (0, 0, -0.8) mm using constant speed }"
    )
    result = tissuec.run(scene(orders=orders), companion="off")
    _, force = felt(result, DOWN)
    assert 0.05 < force.max() < RESISTANCE * WIDTH
    assert not any("mm^2" in one.cause for one in cut_events(result))


def test_a_knife_that_is_drawn_back_feels_nothing():
    orders = (
        "from 0 s to 30 ms: move knife by (0, 0, -5) mm using constant speed\n"
        "  from 30 ms to 60 ms: move knife by (0, 0, 5) mm using constant speed\n"
        "  from 0 s to 60 ms: cut block with knife"
    )
    result = tissuec.run(scene(orders=orders), companion="off")
    time, force = felt(result, DOWN)
    assert force[(time > 0.02) & (time < 0.029)].min() > 0.2
    assert np.abs(force[time > 0.04]).max() == 0.0


SHORT = (
    "from 0 s to 10 ms: { cut block with knife; "
    "move knife by (0, 0, -2) mm using constant speed }"
)


def test_a_run_that_is_resumed_within_a_cut_gives_the_same_bytes():
    compiled = compiled_scene(scene(cell=2.5, orders=SHORT, duration=10))
    _, *parts = same_when_resumed(compiled, "force of knife", 3, 6)
    assert any(first.state.blades for first, _ in parts)


def test_scipy_agrees():
    near = ((5.3, -4, 10.05), (5.3, 14, 10.05), (0, 0, -2), 1.0)
    orders = (
        "from 0 s to 2 ms: { cut block with knife; "
        "move knife by (0, 0, -2) mm using constant speed }"
    )
    found = validated(scene(way=near, cell=5.0, orders=orders, duration=2))
    assert found.verdict == "kept", found.reasons


def test_threads_change_no_bit(threads_in_small_nets):
    compiled = compiled_scene(scene(cell=1.25, orders=SHORT, duration=10))
    same_on_two_threads(compiled, "force of knife")


def test_a_piece_of_an_edge_stores_what_it_pushes_with():
    """Force and energy below, at and beyond the lag against F g²/2ℓ and F (g - ℓ/2)."""
    nodes = np.array([0, 1, 2, 3])
    edge = CuttingEdge.of(
        np.zeros(4, dtype=np.int64), nodes, np.array([-0.5, -0.5, 0.25, 0.75]),
        np.array([0.0, 0.0, -1.0]), np.array([3.0]), 2e-3,
    )  # fmt: skip
    for ahead, push, energy in (
        (-1e-3, 0.0, 0.0), (1e-3, 1.5, 0.75e-3), (2e-3, 3.0, 3e-3), (5e-3, 3.0, 12e-3),
    ):  # fmt: skip
        x = np.zeros((4, 3))
        x[2:, 2] = -ahead
        found, known = np.zeros((2, 4, 3))
        edge.add_forces(0.0, x, np.zeros_like(x), found)
        PushingEdge(edge).add_forces(0.0, x, np.zeros_like(x), known)
        assert_allclose(found[:, 2], push * np.array([-0.5, -0.5, 0.25, 0.75]), atol=1e-15)
        assert_allclose(known, found, atol=1e-15)
        assert float(edge.energy(0.0, x)) == pytest.approx(energy, abs=1e-18)
        assert PushingEdge(edge).energy(0.0, x) == pytest.approx(energy, abs=1e-18)
        assert not found[:, :2].any()


def test_an_edge_that_cuts_nothing_is_noted():
    orders = (
        "from 0 s to 10 ms: { cut block with knife; "
        "move knife by (0, 0, 3) mm using constant speed }"
    )
    result = tissuec.run(scene(orders=orders, duration=10), companion="off")
    assert any("nothing was cut" in one.cause for one in result.events)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("kind is scalpel; edge from", "kind is probe; radius = 1 mm; axis from", "of kind"),
        ("edge from (5.3, -4, 10.3) mm", "edge from (5.3, 14, 10.3) mm", "no length"),
        ("kind is scalpel; edge from (5.3, -4, 10.3) mm to (5.3, 14, 10.3) mm",
         "kind is scissors", "has no edge"),
        ("made of elements; tissue is gel",
         "made of elements; tissue is gel; rupture is allowed", "be divided"),
        ("from 0 s to 60 ms: { cut block with knife; ",
         "at 0 s: cut block with knife\n  from 0 s to 60 ms: { ", "for a scalpel: from"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_reported(old, new, message):
    text = scene().replace(old, new)
    if "scissors" in new:
        text = text.replace("; move knife by (0, 0, -6) mm using constant speed", "")
        text = text.replace("force(knife) every 1 ms; ", "")
    if "rupture" in new:
        text = text.replace("Poisson's ratio = 0.3", "Poisson's ratio = 0.3; strength = 50 kPa")
    with pytest.raises(CompileError, match=message):
        compiled_scene(text)


def test_an_edge_is_seen_once(run):
    """As the shape of its tool, and not as scissors that the sentence names."""
    result = run(way=DOWN, cell=2.5)
    moments = Moments.of(result, np.arange(len(result.times)))
    assert [one.name for one in solids(moments)] == ["knife"]
    assert not any(one.name == "knife" for one in courses(moments))


def test_a_gap_that_a_scalpel_cuts_is_not_said_to_be_none():
    text = scene().replace("output {", "output { gap(block) every 1 ms;")
    assert not check_request(Request(Source("x.tis", text)))[1]
