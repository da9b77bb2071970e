"""Springs between bodies: what they join, and what they do, against closed forms and SciPy."""

import numpy as np
import pytest

from tests.engine.running import set_pace
from tests.every import every
from tests.validate.scenes import compiled_scene, quantity, validated
from tests.whole_runs import carried_out
from tissuec.compiler.bodies.joints import nearest_pairs
from tissuec.compiler.checks import check_all
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.mechanics import observables
from tissuec.pipeline import compile_request, simulate
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request
from tissuec.script.measures.snapshot import Snapshot

MASSES = """language 1
tissue rope {{ spring constant = 40 N/m; viscosity = {viscosity}; mass = 5 g
             breaking force = 1 N; {more} }}
body one {{ mesh is explicit; tissue is rope }}
body two {{ mesh is explicit; tissue is rope }}
table nodes of one in mm with columns "id x" {{ 1 0 }}
table nodes of two in mm with columns "id x vx in mm/s" {{ 1 10 {speed} }}
joint link {{ springs from one to two; tissue is rope; {rupture} }}
environment {{ gravity = {gravity} m/s^2 }}
script {{ {script} }}
simulate {{ duration = {duration}; tolerance = 1e-5 }}
output {{ energy every 5 ms }}
"""


def masses(script="", duration="0.2 s", *, speed=0, viscosity="0 N*s/m", more="", rupture="",
           gravity="(0, 0, 0)"):  # fmt: skip
    return MASSES.format(
        script=script, duration=duration, speed=speed, viscosity=viscosity, more=more,
        rupture=rupture, gravity=gravity,
    )  # fmt: skip


WOUND = """language 1
tissue gum {{ spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 20 mg }}
tissue silk {{ spring law is tension only; spring constant = 100 N/m; viscosity = 10 mN*s/m
             breaking force = 0.2 N; {more} }}
body left {{ mesh is sheet {{ corner = (-6, 0, 0) mm; first edge = (4, 0, 0) mm
  second edge = (0, 6, 0) mm; columns = 3; rows = 4; diagonals is both }}; tissue is gum }}
body right {{ mesh is sheet {{ corner = (2, 0, 0) mm; first edge = (4, 0, 0) mm
  second edge = (0, 6, 0) mm; columns = 3; rows = 4; diagonals is both }}; tissue is gum }}
set left edge = nodes of left where x > -3 mm
set right edge = nodes of right where x < 3 mm
set far left = nodes of left where x < -5 mm
set far right = nodes of right where x > 5 mm
joint seam {{ springs from left edge to right edge; tissue is silk; rupture is allowed }}
set first stitch = springs of seam in [1]
environment {{ gravity = (0, 0, 0) m/s^2; damping = 10 mN*s/m }}
script {{ {script} }}
simulate {{ duration = {duration}; tolerance = 1e-3 }}
output {{ trajectory every 5 ms; tension of seam every 5 ms; energy every 5 ms }}
"""


def wound(script="at 0 s: fix far left; at 0 s: fix far right", duration="0.1 s", more=""):
    return WOUND.format(script=script, duration=duration, more=more)


DRAWN = """at 0 s: fix far left; at 0 s: hold far right
  from 0 s to 0.05 s: tighten first stitch to 1 mm using smooth profile
  from 0.02 s to 0.08 s: tighten seam to 1 mm using smooth profile"""


def ran(text, **options):
    compiled = compiled_scene(text)
    outcome, recording = carried_out(compiled, **options)
    return compiled, recording, outcome


def seam_of(state):
    (joint,) = state.network.joints
    return joint.springs


def tension(state):
    every = observables.tension(state, state.position, state.velocity)
    return every[seam_of(state)]


def kinds(outcome):
    return [h.kind for _, h in outcome.logged_events]


# --- which nodes are joined -------------------------------------------------------------------


def by_brute_force(position, first, second):
    """Return the pairs by looking at all of them."""
    few, many = (first, second) if len(first) <= len(second) else (second, first)
    pairs = []
    for node in few:
        distance = [float(np.linalg.norm(position[node] - position[other])) for other in many]
        alike = [
            o for o, d in zip(many, distance, strict=True) if d <= min(distance) * 1.000001
        ]
        pairs.append((node, min(alike)) if few is first else (min(alike), node))
    return np.array(pairs)


@every("seed", range(20))
def test_each_node_of_the_smaller_side_is_joined_to_the_nearest(seed):
    random = np.random.default_rng(seed)
    count = int(random.integers(2, 120))
    position = random.normal(size=(count, 3))
    if seed % 2:  # a lattice, where many are equally near
        position = np.round(2.0 * position) * 0.1 + random.normal(size=3)
    order, cut = random.permutation(count), int(random.integers(1, count))
    first, second = np.sort(order[:cut]), np.sort(order[cut:])
    pairs, distance = nearest_pairs(position, first, second)
    assert pairs.tolist() == by_brute_force(position, first, second).tolist()
    drawn = position[pairs[:, 0]] - position[pairs[:, 1]]
    assert distance == pytest.approx(np.linalg.norm(drawn, axis=1), abs=1e-15)
    assert len(np.unique(pairs, axis=0)) == min(len(first), len(second))


def test_a_joint_gets_what_its_tissue_says_behind_the_springs_of_all_bodies():
    compiled = compiled_scene(wound(more="prestress = 10 %"))
    network = compiled.network
    (joint,) = network.joints
    assert joint.name == "seam"
    assert (joint.springs.start, joint.springs.stop) == (
        network.body_springs,
        len(network.springs.ends),
    )
    places = network.position[network.springs.ends[joint.springs]]
    assert np.ptp(places[:, :, 0], axis=1) == pytest.approx(4e-3)
    assert np.ptp(places[:, :, 1], axis=1) == pytest.approx(0.0, abs=1e-15)
    assert network.springs.rest[joint.springs] == pytest.approx(0.9 * 4e-3)
    assert network.springs.stiffness[joint.springs].tolist() == [100.0] * 4
    assert network.springs.strength[joint.springs].tolist() == [0.2] * 4
    assert network.springs.ids[joint.springs].tolist() == [1, 2, 3, 4]
    origin = network.provenance["stiffness"][joint.springs.start]
    assert origin.span.text == "spring constant = 100 N/m"
    assert network.springs.laws[network.springs.law[joint.springs.start]].name == "tension only"


def test_reach_leaves_out_what_is_drawn_further_apart():
    text = wound().replace(
        "from left edge to right edge", "from left to right edge; reach = 4 mm"
    )
    joined = compiled_scene(text).network
    assert (
        len(joined.springs.ends) - joined.body_springs == 4
    )  # 4 mm apart, whatever the rounding
    text = text.replace("reach = 4 mm", "reach = 3.99 mm")
    with pytest.raises(CompileError, match="is empty"):
        compiled_scene(text)


def test_all_pairs_within_reach_are_joined():
    text = wound().replace("joint seam {", "joint seam { pairs is all; reach = 5 mm;")
    compiled, _ = compile_request(Request(Source("wound.tis", text)))
    network = compiled.network
    ends = network.springs.ends[network.body_springs :]
    x = network.position
    left, right = (np.flatnonzero(np.isclose(x[:, 0], side)) for side in (-2e-3, 2e-3))
    # The edges are 4 mm apart and their nodes 2 mm: straight across, and √20 < 5 mm oblique.
    apart = np.linalg.norm(x[left][:, None] - x[right][None], axis=2)
    expected = np.argwhere(apart <= 5e-3)
    assert len(expected) == 4 + 2 * 3
    assert np.array_equal(ends, np.stack([left[expected[:, 0]], right[expected[:, 1]]], axis=1))


def test_all_pairs_need_a_reach():
    text = wound().replace("joint seam {", "joint seam { pairs is all;")
    with pytest.raises(CompileError, match="TIS304"):
        compile_request(Request(Source("wound.tis", text)))


def test_a_scene_without_joints_has_none_of_their_springs():
    text = masses().replace("joint link { springs from one to two; tissue is rope;  }", "")
    network = compiled_scene(text).network
    assert network.joints == () and network.body_springs == 0 and not network.can_be_drawn_in


def test_what_is_wrong_with_a_body_hides_nothing_of_a_joint():
    text = wound().replace("diagonals is both }; tissue is gum }", "diagonals is both } }", 1)
    text = text.replace("from left edge", "from lft edge")
    with pytest.raises(CompileError) as caught:
        compiled_scene(text)
    assert [d.code for d in caught.value.diagnostics] == ["TIS304", "TIS301"]


def test_a_body_that_is_wrong_leaves_orders_about_its_joint_aside():
    text = wound("at 0 s: tie seam with square knot; at 0 s: change viscosity of seam by 2")
    with pytest.raises(CompileError) as caught:
        compiled_scene(text.replace("tissue is gum }", "tissue is gum; mass = -1 g }", 1))
    assert [d.code for d in caught.value.diagnostics] == ["TIS308"]


def test_a_joint_cannot_join_springs_of_joints():
    text = wound() + "set both = [first stitch]\n"
    text += "joint again { springs from both to right; tissue is silk }\n"
    with pytest.raises(CompileError) as caught:
        compiled_scene(text)
    assert {d.code for d in caught.value.diagnostics} == {"TIS314"}


# --- what they do -----------------------------------------------------------------------------


def test_two_masses_of_different_bodies_swing_as_calculated():
    _, _, outcome = ran(masses(speed=100, duration="0.15 s"))
    state = outcome.state
    omega = np.sqrt(2.0 * 40.0 / 5e-3)
    apart = 10e-3 + 0.1 / omega * np.sin(omega * 0.15)
    middle = 5e-3 + 0.05 * 0.15
    # The largest displacement is some 10 mm, of which 1e-5 is promised.
    assert state.position[:, 0] == pytest.approx(
        [middle - apart / 2.0, middle + apart / 2.0], abs=1e-7
    )


def test_what_hangs_on_a_joint_stretches_it_by_its_weight():
    script = "at 0 s: fix one; at 0 s: settle"
    _, _, outcome = ran(masses(script, more="prestress = 20 %", gravity="(10, 0, 0)"))
    state = outcome.state
    assert tension(state) == pytest.approx(5e-3 * 10.0, rel=1e-9)
    assert state.position[1, 0] == pytest.approx(8e-3 + 0.05 / 40.0, rel=1e-9)


def test_every_spring_of_a_joint_is_drawn_in_to_the_length_and_keeps_balance():
    _, _, outcome = ran(wound(DRAWN, "0.2 s"))
    state = outcome.state
    springs = seam_of(state)
    assert state.springs.rest[springs] == pytest.approx(1e-3, rel=1e-12)
    # At rest, the seam and the support of either far edge bear the same force.
    pull = observables.inner_forces(state, 0.2, state.position, state.velocity).node
    first, second = state.network.springs.ends[springs].T
    along = state.position[second] - state.position[first]
    along /= np.linalg.norm(along, axis=1)[:, None]
    force = (tension(state)[:, None] * along).sum(axis=0)
    is_left = np.arange(len(pull)) < 12
    held = state.held
    assert force[0] > 1e-2
    assert pull[held & is_left].sum(axis=0) == pytest.approx(force, abs=1e-3 * force[0])
    assert pull[held & ~is_left].sum(axis=0) == pytest.approx(-force, abs=1e-3 * force[0])


def test_what_is_short_enough_is_left_as_it_is():
    script = """at 0 s: fix left; at 0 s: fix right; at 0 s: tighten first stitch to 3 mm
      at 0.01 s: tighten seam to 3.5 mm; at 0.02 s: tighten seam to 3.7 mm
      at 0.03 s: loosen first stitch to 5 mm"""
    _, _, outcome = ran(wound(script, "0.025 s"))
    state = outcome.state
    assert state.springs.rest[seam_of(state)] == pytest.approx([3e-3, 3.5e-3, 3.5e-3, 3.5e-3])
    assert kinds(outcome) == ["fix", "fix", "tighten", "tighten", "note"]
    _, _, outcome = ran(wound(script, "0.04 s"))
    assert outcome.state.springs.rest[seam_of(state)] == pytest.approx(
        [5e-3, 3.5e-3, 3.5e-3, 3.5e-3]
    )


def test_drawing_in_between_held_nodes_is_work():
    script = """at 0 s: fix left; at 0 s: fix right
      from 0 s to 0.05 s: tighten seam to 2.5 mm using smooth profile"""
    _, recording, _ = ran(wound(script))
    _, rows = recording.energy_arrays()
    _, elastic, _, work, _, _ = rows.T
    assert elastic[-1] == pytest.approx(4 * 0.5 * 100.0 * 1.5e-3**2, rel=1e-12)
    # Without motion nothing but the quadrature of the work can be wrong.
    assert work == pytest.approx(elastic, abs=1e-6 * elastic[-1])


def test_a_stitch_holds_a_part_of_its_strength_and_comes_undone_above_it():
    script = """at 0 s: fix left; at 0 s: hold right; at 0 s: tie seam with square knot
      from 0 s to 1 s: move right by (2, 0, 0) mm using ramp"""
    _, _, outcome = ran(wound(script, "1 s"))
    state = outcome.state
    assert state.springs.strength[seam_of(state)] == pytest.approx(0.695 * 0.2)
    (when,) = {time for time, h in outcome.logged_events if h.kind == "rupture"}
    pulled = 0.695 * 0.2 - 10e-3 * 2e-3  # what dampers bear is no stretch
    assert when == pytest.approx(pulled / 100.0 / 2e-3, rel=1e-6)
    assert not state.alive[seam_of(state)].any()


def test_a_knot_bears_no_more_than_the_thread_and_is_tied_twice_at_no_cost():
    script = "at 0 s: fix left; {}; at 0 s: fix right"
    for knot, holds in (
        ("at 0 s: tie seam with granny knot of 1 N", 0.2),
        ("at 0 s: tie seam with granny knot of 50 mN", 0.05),
        ("at 0 s: tie seam with square knot; at 0 s: tie seam with square knot", 0.139),
    ):
        _, _, outcome = ran(wound(script.format(knot), "1 ms"))
        assert outcome.state.springs.strength[seam_of(outcome.state)] == pytest.approx(holds)


def test_joints_hold_pieces_together_and_leave_them_pieces():
    text = wound() + "set wound = [left, right]\nexpect count(pieces of wound) == 2 over run\n"
    _, _, outcome = ran(text + "expect gap(wound) between 3.9 mm and 4.1 mm over run\n")
    assert outcome.failures == ()
    pieces = Snapshot.of(outcome.state).pieces
    assert len(np.unique(pieces)) == 2
    inside = compiled_scene(text + "expect count(springs of wound) == 4 at 0 s\n")
    assert len(inside.groups.springs_inside(np.arange(24))) == inside.network.spring_count


def test_springs_of_joints_are_cut_and_changed_by_name():
    script = """at 0 s: fix left; at 0 s: fix right; at 0 s: change spring constant of seam by 2
      at 0 s: cut first stitch
      at 1 ms: cut seam along plane through (0, 5, 0) mm facing (-1, 0.6, 0)"""
    _, _, outcome = ran(wound(script, "2 ms"))
    state = outcome.state
    assert state.springs.stiffness[seam_of(state)].tolist() == [200.0] * 4
    assert state.alive[: seam_of(state).start].all()
    assert kinds(outcome).count("cut") == 2


def test_a_thread_that_is_tightened_leaves_others_under_way():
    rows = "; ".join(f"{number} {number}" for number in range(1, 11))
    text = f"""language 1
tissue gum {{ spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 20 mg }}
body dust {{ mesh is explicit; tissue is gum }}  # so that nodes of A count as springs of B do
table nodes of dust in mm with columns "id x" {{ {rows} }}
body A {{ mesh is thread {{ line from (0, 20, 0) mm to (8, 20, 0) mm; pieces = 8
  thickness = 0.1 mm }}; tissue is gum }}
body B {{ mesh is thread {{ line from (0, 30, 0) mm to (8, 30, 0) mm; pieces = 8
  thickness = 0.1 mm }}; tissue is gum }}
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: {{ fix A; fix B }}; from 0 s to 20 ms: tighten B to 6 mm
  from 10 ms to 15 ms: tighten A to 6 mm }}
simulate {{ duration = 30 ms }}
"""
    compiled, _, outcome = ran(text)
    for thread in compiled.network.threads.values():
        assert outcome.state.springs.rest[thread.pieces].sum() == pytest.approx(6e-3)


# --- against SciPy, interrupted, and in files -------------------------------------------------


@pytest.mark.parametrize("more", ["", "relaxing constant = 50 N/m; relaxation time = 20 ms"])
def test_a_seam_agrees_with_scipy(more):
    script = (
        DRAWN
        + """; at 0.1 s: tie seam with granny knot
      from 0.1 s to 0.14 s: move far right by (5, 0, 0) mm using smooth profile"""
    )
    found = validated(wound(script, "0.14 s", more), rtol=1e-6)
    assert quantity(found, "position").is_kept
    assert quantity(found, "energy balance").is_kept


def test_a_run_that_is_interrupted_while_sewing_goes_on_to_the_same_end(monkeypatch):
    set_pace(monkeypatch, "compiled", 2000)
    text = wound(DRAWN, "0.06 s")
    _, _, whole = ran(text)
    _, recording, first = ran(text, interrupt=lambda: True)
    assert first.kind == "interrupted" and 0.0 < first.state.time < 0.06
    _, _, second = ran(text, resume=recording.state)
    assert np.array_equal(second.state.position, whole.state.position)
    assert np.array_equal(second.state.springs.rest, whole.state.springs.rest)


def test_files_know_joints_by_name(tmp_path):
    script = "at 0 s: fix far left; at 0 s: fix far right; at 1 ms: cut first stitch"
    request = Request(Source("wound.tis", wound(script, "10 ms")))
    compiled, _ = compile_request(request)
    path = simulate(compiled, tmp_path / "wound.vtkhdf", request=request).path
    with Trajectory.open(path) as trajectory:
        network = trajectory.network
        (joint,) = network.joints
        assert (joint.name, joint.springs) == ("seam", compiled.network.joints[0].springs)
        assert np.array_equal(network.springs.ends, compiled.network.springs.ends)
        assert network.owner(network.spring_count - 1).name == "seam"
        drawn = [
            trajectory.cells(frame).line_numbers for frame in (0, len(trajectory.times) - 1)
        ]
        assert [int((springs >= joint.springs.start).sum()) for springs in drawn] == [4, 3]
        assert trajectory.logs["tension of seam"].columns == tuple(
            f"spring {number}" for number in (1, 2, 3, 4)
        )


# --- warnings ---------------------------------------------------------------------------------


def codes(text):
    return sorted(d.code for d in check_all(compiled_scene(text), thorough=True))


LOOSE = """language 1
tissue gum { spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 20 mg }
body frame { mesh is explicit; tissue is gum }
table nodes of frame in mm with columns "id x y z" { 1 0 0 0; 2 9 0 0; 3 0 9 0; 4 0 0 9 }
table springs of frame with columns "a b" { 1 2; 1 3; 1 4; 2 3; 2 4; 3 4 }
body chain { mesh is explicit; tissue is gum }
table nodes of chain in mm with columns "id x y z" { 1 5 5 5; 2 6 7 5; 3 7 7 8; 4 9 9 9 }
table springs of chain with columns "a b" { 1 2; 2 3 }
set rest of chain = nodes of chain in [1, 2, 3]
set loose = nodes of chain in [4]
JOINTS
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix frame }
simulate { duration = 1 s }
""".replace("set rest of chain", 'set "rest of chain"')


def test_warnings_see_what_joints_hold():
    alone = LOOSE.replace("JOINTS", "")
    assert {"W302", "W303"} <= set(codes(alone))
    joined = "".join(
        f"""joint {name} {{ springs from chain to corner{name}; tissue is gum }}
        set corner{name} = nodes of frame in [{node}]\n"""
        for name, node in (("A", 1), ("B", 2), ("C", 3))
    ).replace("from chain", 'from "rest of chain"')
    found = codes(LOOSE.replace("JOINTS", joined))
    assert "W302" in found and "W303" in found  # each corner holds one node alone
    every = LOOSE.replace("JOINTS", joined).replace("[1, 2, 3]", "[2]")
    every += "joint D { springs from loose to corner1; tissue is gum }\n".replace(
        "corner1", "cornerA"
    )
    assert "W302" not in codes(every)


def test_a_joint_of_no_length_and_one_that_cannot_rupture_are_told():
    text = masses().replace("1 10 0", "1 0 0") + "expect not ruptured(link) over run\n"
    # The expectation, and the breaking force of the rope, are in vain.
    assert codes(text) == ["W304", "W404", "W404"]
    tied = text.replace("script { ", "script { at 0 s: tie link with square knot of 1 N ")
    assert codes(tied) == ["W304"]
