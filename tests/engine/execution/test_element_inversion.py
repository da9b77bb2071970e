"""Finite elements that turn inside out: which and when, and how nets are counted."""

import json

import numpy as np
from click.testing import CliRunner

import tissuec
from tests.every import every
from tissuec.cli import group
from tissuec.engine.execution.doubts import WATCHES
from tissuec.engine.execution.doubts.elements import INSIDE_OUT
from tissuec.engine.execution.doubts.turning import TURNED
from tissuec.model.blocks import NetSize

SCENE = """language 1
param pull = 10 mm
tissue net { spring constant = 20 N/m; density = 1000 kg/m^3; retardation time = 5 ms }
tissue gel { Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms }
body block {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 20, 20) mm }
  tissue is gel; made of elements
}
body post {
  mesh is lattice { kind is sodium chloride; cell = 5 mm
    reach is second neighbours; box from (30, 0, 0) mm to (35, 5, 5) mm }
  tissue is net
}
set held = nodes of block where z < 0.1 mm or z > 14 mm
set inner = nodes of block where x > 9 mm and x < 11 mm and y > 9 mm and y < 11 mm
  and z > 9 mm and z < 11 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix held
  from 0 s to 10 ms: move inner by (0, 0, pull) using smooth profile }
simulate { duration = 12 ms; tolerance = 1e-3 }
output { trajectory every 4 ms }
"""
SIDES = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1],
     [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float,
)  # fmt: skip


def scene_of(**params):
    return tissuec.compile(SCENE, params=params)


def least_volume(nodes, position):
    """Return the least derivative of the trilinear map at Gauss's points, shape (element,)."""
    found = np.full(len(nodes), np.inf)
    for point in SIDES / np.sqrt(3.0):
        slopes = np.array(
            [
                [0.5 * s[k] * np.prod([0.5 * (1 + s[j] * point[j]) for j in range(3) if j != k])
                 for k in range(3)]
                for s in SIDES
            ]
        )  # fmt: skip
        map_ = np.einsum("eax,ak->exk", position[nodes], slopes)
        found = np.minimum(found, np.linalg.det(map_))
    return found


def elements(scene):
    (block,) = (block for block in scene.network.blocks if block.kind == "elements")
    return block.field


def watch(scene):
    return WATCHES["elements inside out"].of(scene.network, scene.plan)


def count(found):
    return sum(one.count for one in found)


def test_elements_are_counted_one_by_one():
    scene = scene_of()
    drawn, nodes = scene.network.position, elements(scene).nodes
    state = scene.plan.start(scene.network)
    block = scene.network.bodies[0].nodes
    rng = np.random.default_rng(3)
    counts = set()
    for size in (0.0, 1e-3, 2e-3, 3e-3):
        x = drawn.copy()
        x[block] += rng.normal(scale=size, size=x[block].shape)
        expected = np.flatnonzero(least_volume(nodes, x) <= 0.0)
        found = list(watch(scene).look(state, x))
        assert count(found) == len(expected)
        counts.add(len(expected))
        if len(expected):
            assert found[0].where.startswith(f"in hexahedron {expected[0] + 1} around (")
    assert {0} < counts


def test_looks_that_are_left_out_miss_nothing():
    """Between looks, nodes move by less than what can invert any element."""
    scene = scene_of()
    drawn, nodes = scene.network.position, elements(scene).nodes
    state, one = scene.plan.start(scene.network), watch(scene)
    way = np.zeros_like(drawn)
    way[np.linalg.norm(drawn - [0.01, 0.01, 0.01], axis=1) < 1e-6, 2] = 10e-3
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    for part in np.linspace(0.0, 1.0, 101):
        x = (drawn + part * way) @ turn.T + [1.0, -2.0, 3.0]
        assert count(one.look(state, x)) == int((least_volume(nodes, x) <= 0.0).sum())


def test_elements_that_have_lost_an_edge_are_not_counted():
    scene = scene_of()
    x = scene.network.position * [1.0, 1.0, -1.0]
    state = scene.plan.start(scene.network)
    assert count(f for f in watch(scene).look(state, x) if f.unit == "element") == 64
    state.lose(np.flatnonzero((scene.network.line_ends == 0).any(axis=1))[:1])
    (found,) = (f for f in watch(scene).look(state, x) if f.unit == "element")
    assert found.count == 63  # node 0 is a corner of one element only
    assert found.where.startswith("in hexahedron 2 around")


def test_a_node_that_is_pulled_through_is_found_and_every_output_counts_elements(tmp_path):
    scene, result = tmp_path / "pull.tis", tmp_path / "pull.vtkhdf"
    scene.write_text(SCENE, encoding="utf-8")

    def said(*words):
        found = CliRunner().invoke(group, [*map(str, words)], standalone_mode=False)
        return found.stdout + found.stderr

    net = "133 nodes, 64 elements, 24 springs"
    assert f"({net})" in said("check", scene)
    assert net in repr(scene_of())
    talk = said("run", scene, "-o", result, "--companion", "off")
    assert f"  {net}; " in talk
    with tissuec.load(result) as run:
        doubts = {each.kind: each for each in run.doubts}
        assert set(doubts) == {INSIDE_OUT, TURNED}  # opposite sides are turned on the way
        doubt = doubts[INSIDE_OUT]
        nodes, last = elements(scene_of()).nodes, run.position[-1]
        assert doubt.last == int((least_volume(nodes, last) <= 0.0).sum())
        assert doubt.most > 0  # they push back, and may have turned again by then
        assert doubt.subject == "block"
        # Half of 10 mm is the edge of an element, and no sooner than that it is flat.
        assert 5e-3 < doubt.time <= 12e-3
        notes = [(each.cause, each.time) for each in run.events if each.kind == "note"]
        assert sorted(notes) == sorted((each.what, each.time) for each in doubts.values())
        assert run.network.size == NetSize(133, 24, 64)
        assert [body.size for body in run.network.bodies] == [
            NetSize(125, 0, 64), NetSize(8, 24),
        ]  # fmt: skip
        assert f"of {net}" in repr(run)
        assert "body: block, 125 nodes, 64 elements" in repr(run)
    assert "elements of block are inside out" in talk
    facts = json.loads(said("info", result, "--json"))
    assert facts["network"]["elements"] == 64
    assert facts["network"]["springs"] == 24
    page = tmp_path / "pull.html"
    said("report", result, "-o", page)
    assert f"{net}; " in page.read_text(encoding="utf-8")
    assert f"text, {net}" in said("compare", result, result)


def test_a_sound_run_has_no_doubt():
    with tissuec.run(SCENE, params={"pull": "3 mm"}, companion="off") as run:
        assert run.doubts == ()


@every(
    ("size", "words"),
    [
        (NetSize(1, 0), "1 node, 0 springs"),
        (NetSize(8, 0, 1), "8 nodes, 1 element"),
        (NetSize(9, 1, 2), "9 nodes, 2 elements, 1 spring"),
        (NetSize(0, 3), "3 springs"),
    ],
)
def test_a_net_in_words(size, words):
    assert str(size) == words
    assert ("elements" in size.facts) == (size.elements > 0)
