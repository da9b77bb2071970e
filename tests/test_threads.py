"""Threads that are tightened, slide and are tied: against closed forms, ledgers and SciPy."""

import numpy as np
import pytest

from tests.engine.running import set_pace
from tests.validate.scenes import compiled_scene, quantity, validated
from tests.whole_runs import carried_out
from tissuec.core.errors import CompileError
from tissuec.geometry.nearest import CAPSULE
from tissuec.geometry.sweeps import go_through
from tissuec.mechanics import observables
from tissuec.script.measures.snapshot import Snapshot

PIECES, RADIUS, STIFFNESS = 24, 10e-3, 2000.0
AROUND_ROD = """language 1
tissue silk {{ {law} spring constant = 2000 N/m; viscosity = 0.5 N*s/m; mass = 0.05 g }}
body sling {{
  mesh is thread {{ centre = (0, 0, 0) mm; normal = (0, 0, 1); radius = 10.2 mm; pieces = 24
                   thickness = 0.4 mm }}
  tissue is silk
}}
tool rod {{ kind is probe; radius = 10 mm; axis from (0, 0, -20) mm to (0, 0, 20) mm }}
environment {{
  gravity = (0, 0, 0) m/s^2; damping = 30 mN*s/m
  contact is tools only; contact stiffness = 20 N/mm; friction = {friction}
}}
{sets}
script {{ {script} }}
simulate {{ duration = {duration}; tolerance = 1e-4 }}
output {{ energy every 5 ms }}
{expect}
"""


def around_rod(*, script, duration, law="", friction=0, sets="", expect=""):
    return AROUND_ROD.format(
        script=script, duration=duration, law=law, friction=friction, sets=sets, expect=expect
    )


def ran(text, **options):
    compiled = compiled_scene(text)
    outcome, recording = carried_out(compiled, **options)
    return compiled, recording, outcome


def kinds(outcome):
    return [h.kind for _, h in outcome.logged_events]


def tension(state):
    return observables.tension(state, state.position, state.velocity)


# --- a sling around a rod -------------------------------------------------------------------

TIGHTENED = "from 0 s to 0.1 s: tighten sling to 60 mm using smooth profile"


def test_tightened_loop_presses_on_a_rod_by_its_tension_over_the_radius():
    script = TIGHTENED.replace("0.1 s", "0.04 s")
    _, _, outcome = ran(around_rod(script=script, duration="0.08 s"))
    state = outcome.state
    pull = tension(state)[:PIECES]
    assert state.springs.rest[:PIECES].sum() == pytest.approx(60e-3, rel=1e-12)
    assert pull.mean() > 0.1
    # At rest to 1e-4: no damper pulls any more.
    assert pull == pytest.approx(pull.mean(), rel=1e-4)
    contact = state.touching
    forces = np.zeros_like(state.position)
    contact.add_forces(0.0, state.position, state.velocity, forces)
    pressed = np.linalg.norm(forces[contact.nodes], axis=1)
    pressed = pressed[pressed > 0.0]
    assert len(pressed) == PIECES
    # A polygon of n nodes: N = 2 T sin(π/n), in all 2π T (1 - π²/6n²).
    assert pressed == pytest.approx(2.0 * pull.mean() * np.sin(np.pi / PIECES), rel=1e-3)
    per_length = pressed.sum() / (2.0 * np.pi * RADIUS)
    assert per_length == pytest.approx(
        pull.mean() / RADIUS, rel=np.pi**2 / 6 / PIECES**2 + 1e-3
    )


CUBIC = "spring law is polynomial { square = 100 kN/m^2; cube = 4e7 N/m^3 };"


@pytest.mark.parametrize(
    "law",
    [
        pytest.param("", marks=pytest.mark.slow, id="linear"),
        pytest.param("spring law is tension only;", marks=pytest.mark.slow, id="tension only"),
        pytest.param(CUBIC, id="cubic"),
    ],
)
def test_energy_of_drawing_in_is_booked_whatever_the_law(law):
    script = (
        TIGHTENED.replace("0.1 s", "25 ms") + "; from 30 ms to 50 ms: loosen sling to 61 mm"
    )
    text = around_rod(script=script, duration="50 ms", law=law)
    _, recording, _ = ran(text)
    _, rows = recording.energy_arrays()
    kinetic, elastic, gravity, work, lost, switched = rows.T
    size = np.abs(work).max()
    assert size > 1e-4
    # A tenth of the tolerance of 1e-4 is what balances are held to.
    assert kinetic + elastic + gravity - work + lost - switched == pytest.approx(
        elastic[0], abs=1e-5 * size
    )


def test_slow_work_of_drawing_in_is_the_elastic_energy_that_it_leaves():
    text = around_rod(script=TIGHTENED, duration="0.1 s")
    _, recording, outcome = ran(text)
    _, rows = recording.energy_arrays()
    _, elastic, _, work, _, _ = rows[-1]
    # What dampers take of it falls with the time that it takes.
    assert work == pytest.approx(elastic, rel=0.02)
    stretch = tension(outcome.state)[:PIECES] / STIFFNESS
    springs = 0.5 * STIFFNESS * (stretch**2).sum()
    assert springs < elastic  # the rest is that of the contact


def test_tightening_agrees_with_scipy():
    script = TIGHTENED.replace("0.1 s", "10 ms") + "; at 11 ms: loosen sling to 61 mm"
    found = validated(around_rod(script=script, duration="13 ms"), rtol=1e-6)
    assert quantity(found, "position").is_kept
    assert quantity(found, "energy balance").is_kept


def test_a_run_that_is_interrupted_while_tightening_goes_on_to_the_same_end(monkeypatch):
    set_pace(monkeypatch, "compiled", 500 * PIECES)
    text = around_rod(script=TIGHTENED, duration="0.02 s").replace(
        "to 0.1 s: tighten", "to 0.02 s: tighten"
    )
    _, _, whole = ran(text)

    _, recording, first = ran(text, interrupt=lambda: True)
    assert first.kind == "interrupted" and 0.0 < first.state.time < 0.02
    _, _, second = ran(text, resume=recording.state)
    assert np.array_equal(second.state.position, whole.state.position)
    assert np.array_equal(second.state.springs.rest, whole.state.springs.rest)


def test_friction_lets_the_tension_grow_as_around_a_capstan():
    friction = 0.2
    text = around_rod(
        script="""at 0 s: cut gap; at 0 s: tighten sling to 61.6 mm
          at 0 s: push slack with 0.1 N along (0, -1, 0)
          from 0 s to 0.5 s: move end by (2.588, 9.659, 0) mm using smooth profile""",
        sets="""set slack = nodes of sling where x > 10.1 mm
          set end = nodes of sling where y < 0 mm and x > 9 mm
          set gap = springs of sling in [2]""",
        duration="0.36 s", friction=friction,
    ).replace("30 mN*s/m", "1 mN*s/m")  # fmt: skip
    compiled, _, outcome = ran(text)
    state = outcome.state
    x, chain = state.position[:PIECES], np.arange(PIECES)
    pull = {
        tuple(e): t
        for e, t in zip(compiled.network.springs.ends.tolist(), tension(state), strict=True)
    }
    pulls = np.array([pull[i, i + 1] for i in chain[:-1]])
    along = np.diff(x, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    turned = np.arccos(np.clip((along[1:] * along[:-1]).sum(axis=1), -1.0, 1.0))
    assert turned.sum() > 5.0
    wanted = ((1 + friction * np.tan(turned / 2)) / (1 - friction * np.tan(turned / 2))).prod()
    assert wanted == pytest.approx(np.exp(friction * turned.sum()), rel=0.02)
    assert pulls[-1] / pulls[0] == pytest.approx(wanted, rel=0.02)


# --- a sling around tissue ------------------------------------------------------------------

VESSEL = """language 1
tissue wall { spring constant = 60 N/m; viscosity = 60 mN*s/m; mass = 20 mg }
tissue silk { spring constant = 2000 N/m; viscosity = 300 mN*s/m; mass = 20 mg }
body vessel {
  mesh is tube { axis from (-6, 0, 0) mm to (6, 0, 0) mm; radius = 3 mm; rings = 5; sides = 8
                 diagonals is both }
  tissue is wall
}
body sling {
  mesh is thread { centre = (0, 0, 0) mm; normal = (1, 0, 0); radius = 3.9 mm; pieces = 16
                   thickness = 1 mm }
  tissue is silk
}
set ends = nodes of vessel where x < -5 mm or x > 5 mm
set waist = nodes of vessel where x between -1 mm and 1 mm
environment { gravity = (0, 0, 0) m/s^2; damping = 10 mN*s/m; contact is tools only
              contact stiffness = 2 N/mm; friction = 0.3 }
script {
  at 0 s: fix ends
  from 0 s to 0.2 s: tighten sling to 15 mm using smooth profile
  SCRIPT
}
simulate { duration = DURATION; tolerance = 1e-4 }
output { energy every 10 ms }
"""


def vessel(script="", duration="0.25 s"):
    return VESSEL.replace("SCRIPT", script).replace("DURATION", duration)


def loop_length(position):
    return np.linalg.norm(position - np.roll(position, 1, axis=0), axis=1).sum()


def test_a_tube_under_a_tightened_sling_is_as_narrow_as_the_sling():
    compiled, recording, outcome = ran(vessel())
    tube, sling = (outcome.state.position[body.nodes] for body in compiled.network.bodies)
    ring = tube.reshape(5, 8, 3)[2]
    narrow, drawn = loop_length(ring), 2.0 * np.pi * 3e-3
    # The ring lies within the sling by the radius of the thread, and is pressed in a little.
    inside = loop_length(sling) - 2.0 * np.pi * 0.5e-3
    assert narrow < 0.75 * drawn
    assert narrow == pytest.approx(inside, rel=0.05)
    assert loop_length(sling) == pytest.approx(15e-3, rel=0.03)
    assert loop_length(tube.reshape(5, 8, 3)[0]) == pytest.approx(16 * 3e-3 * np.sin(np.pi / 8))
    _, rows = recording.energy_arrays()
    kinetic, elastic, gravity, work, lost, switched = rows.T
    assert kinetic + elastic + gravity - work + lost - switched == pytest.approx(
        0.0, abs=1e-5 * np.abs(work).max()
    )


def turns(polygon, points):
    """Return how often a polygon in a plane goes round each of some points, shape (point,)."""
    arms = [(polygon - point) @ (1.0, 1.0j) for point in points]
    return [round(np.angle(np.roll(arm, -1) / arm).sum() / (2.0 * np.pi)) for arm in arms]


@pytest.mark.slow
def test_no_node_of_a_sling_slips_between_those_of_the_wall_that_it_strangles():
    """Its pieces touch triangles, not nodes alone, also where the wall is folded."""
    script = "from 0.2 s to 0.3 s: tighten sling to 11 mm using smooth profile"
    _, recording, _ = ran(vessel(script, "0.32 s").replace("energy", "trajectory"))
    position = recording.frame_arrays()[1]
    assert loop_length(position[-1, 40:56]) < 12e-3
    for place in position:
        ring, sling = place[16:24, 1:], place[40:56, 1:]
        assert turns(ring, np.zeros((1, 2))) in ([1], [-1])
        assert not any(turns(ring, sling))


def test_a_sling_that_is_cut_lets_go_and_its_pieces_there_do_not_touch():
    cut = "at 0.22 s: cut sling along plane through (0, 0, 0) mm facing (0, 1, 0)"
    _, _, outcome = ran(vessel(cut, "0.5 s"))
    state = outcome.state
    gone = np.flatnonzero(~state.alive[state.network.bodies[1].springs])
    assert len(gone) == 3  # two pieces, and the spring for a slipping knot
    contact = state.touching
    pieces = contact.kind[: len(contact.whole)] == CAPSULE
    assert contact.whole[pieces].sum() == 16 - 2
    ring = state.position[:40].reshape(5, 8, 3)[2]
    assert loop_length(ring) == pytest.approx(16 * 3e-3 * np.sin(np.pi / 8), rel=0.05)


@pytest.mark.slow
def test_a_constricted_tube_agrees_with_scipy():
    text = vessel(duration="0.06 s").replace("to 0.2 s: tighten", "to 0.05 s: tighten")
    assert quantity(validated(text, rtol=1e-6), "position").is_kept


# --- knots ----------------------------------------------------------------------------------

KNOT = """language 1
tissue silk {{ spring constant = 1000 N/m; viscosity = 0 N*s/m; mass = 0.5 g; {strength} }}
body sling {{
  mesh is thread {{ centre = (0, 0, 0) mm; normal = (0, 0, 1); radius = 10 mm; pieces = 4
                   thickness = 0.4 mm }}
  tissue is silk
  {body}
}}
set left = nodes of sling where x < -9 mm
set right = nodes of sling where x > 9 mm
set middle = nodes of sling where x between -1 mm and 1 mm
environment {{ gravity = (0, 0, 0) m/s^2; damping = 1 N*s/m }}
script {{ at 0 s: fix left; {script} }}
simulate {{ duration = {duration}; tolerance = 1e-6 }}
output {{ energy every 10 ms; tension of sling every 5 ms }}
"""
PULLED = """at 0 s: tie sling with {knot}
  at 0 s: settle middle
  from 0 s to 1 s: move right by (14, 0, 0) mm using smooth profile
  from 1 s to 1.5 s: move right by (-1, 0, 0) mm using smooth profile
  from 1.5 s to 2 s: move right by (12, 0, 0) mm using smooth profile
  from 2 s to 2.2 s: move right by (-1, 0, 0) mm using smooth profile"""


def knot(tied="square knot of 2 N", *, duration="2.2 s", script=PULLED, strength="", body=""):
    script = script.format(knot=tied)
    return KNOT.format(script=script, duration=duration, strength=strength, body=body)


def test_a_knot_holds_below_its_limit_and_slips_above_it_at_that_force():
    compiled, recording, outcome = ran(knot())
    found = [(t, h.kind) for t, h in outcome.logged_events if h.kind in ("slip", "seize")]
    assert [kind for _, kind in found] == ["slip", "seize", "slip", "seize"]
    thread = compiled.network.bodies[0].thread
    state = outcome.state
    # It stays longer by what slipped, and never bears more than that force.
    assert state.alive[thread.hold] and not state.alive[thread.slip]
    assert state.springs.rest[thread.hold] > 20e-3
    _, pulls = recording.log_arrays("tension of sling")
    assert pulls.shape[1] == 4  # the pieces; the last one has the knot in it
    slips = pulls[:, thread.hold] >= 2.0 * (1.0 - 1e-12)
    assert slips.sum() > 50
    assert pulls[:, thread.hold].max() == pytest.approx(2.0, rel=1e-12)
    assert pulls[:, 0].max() > 4.0  # the strand without a knot
    assert not any(kind == "rupture" for kind in kinds(outcome))
    _, rows = recording.energy_arrays()
    kinetic, elastic, _, work, lost, switched = rows.T
    balance = kinetic + elastic - work + lost - switched
    assert balance == pytest.approx(balance[0], abs=1e-6 * np.abs(work).max())


OPEN_THREAD = """language 1
tissue silk { spring constant = 1000 N/m; viscosity = 0.5 N*s/m; mass = 0.5 g }
body strand {
  mesh is thread { line from (0, 0, 0) mm to (30, 0, 0) mm; pieces = 3; thickness = 1 mm }
  tissue is silk
}
set left = nodes of strand where x < 1 mm
set right = nodes of strand where x > 29 mm
environment { gravity = (0, 0, 0) m/s^2; damping = 1 N*s/m }
script {
  at 0 s: fix left
  from 0 s to 0.4 s: move right by (6, 0, 0) mm using smooth profile
  TIE
}
simulate { duration = 1 s; tolerance = 1e-6 }
output { tension of strand every 50 ms }
expect tension(strand) < 8 N over run
"""


def test_the_log_of_a_thread_has_its_pieces_and_the_knot_once_it_is_tied():
    """The ends of a tied thread are drawn 3 mm further apart than its knot was tied."""
    _, recording, _ = ran(OPEN_THREAD.replace("TIE", ""))
    time, pulls = recording.log_arrays("tension of strand")
    assert pulls.shape[1] == 3
    assert pulls[-1] == pytest.approx(3 * [2.0], rel=1e-4)  # c 6 mm / 3
    tie = """at 0.5 s: tie strand with square knot of 9 N
      from 0.6 s to 0.8 s: move right by (3, 0, 0) mm using smooth profile"""
    tied, recording, outcome = ran(OPEN_THREAD.replace("TIE", tie))
    (log,) = tied.plan.output.logs
    snapshot = Snapshot.of(outcome.state)
    names = log.measure.columns(log.subjects, snapshot)
    assert names == ("spring 1", "spring 2", "spring 3", "knot")
    _, pulls = recording.log_arrays("tension of strand")
    is_tied = time > 0.5 - 1e-9
    assert np.isnan(pulls[~is_tied, 3]).all()
    assert pulls[is_tied, 3][0] == 0.0
    assert pulls[-1] == pytest.approx([3.0, 3.0, 3.0, 3.0], rel=1e-4)  # c 9 mm / 3, c 3 mm
    assert not outcome.failures


def test_the_log_of_a_loop_that_is_not_tied_has_its_pieces_alone():
    _, recording, _ = ran(knot(script="", duration="0.02 s"))
    assert recording.log_arrays("tension of sling")[1].shape[1] == 4


def test_a_knot_slips_at_the_located_time():
    # Slowly, both strands are chains of two equal springs: T = c (D / 2 - a).
    script = """at 0 s: tie sling with square knot of 2 N
      from 0 s to 0.25 s: move right by (12, 0, 0) mm using smooth profile
      at 0 s: settle middle
      from 0.35 s to 5.35 s: move right by (6, 0, 0) mm using constant speed"""
    text = knot(script=script, duration="0.65 s").replace("1e-6", "1e-5")
    _, _, outcome = ran(text)
    (time,) = [t for t, h in outcome.logged_events if h.kind == "slip"]
    piece = 10e-3 * np.sqrt(2.0)
    apart = 2.0 * (piece + 2.0 / 1000.0)
    expected = (apart - 32e-3) / 6e-3 * 5.0 + 0.35
    assert time == pytest.approx(expected, abs=1e-3)  # drag lets the middle lag behind


def test_slipping_knots_agree_with_scipy():
    found = validated(knot(duration="1.1 s").replace("1e-6", "1e-5"), rtol=1e-7)
    assert quantity(found, "position").is_kept


@pytest.mark.parametrize("viscosity", ["0 N*s/m", "0.5 N*s/m"])
def test_a_knot_slips_while_its_thread_is_drawn_in(viscosity):
    script = """at 0 s: { fix right; tie sling with square knot of 1 N }
      from 0.1 s to 0.5 s: tighten sling to 30 mm"""
    text = knot(script=script.replace("{", "{{").replace("}", "}}"), duration="0.6 s")
    _, recording, outcome = ran(
        text.replace("1e-6", "1e-4").replace("viscosity = 0 N*s/m", f"viscosity = {viscosity}"),
    )
    happened = [h.kind for _, h in outcome.logged_events if h.kind in ("slip", "seize")]
    assert happened[0] == "slip" and len(happened) < 10
    assert tension(outcome.state)[:4].max() == pytest.approx(2.5, rel=1e-3)  # c 5 mm / 2
    thread = outcome.state.network.bodies[0].thread
    bears = tension(outcome.state)[[thread.hold, thread.slip]].sum()
    assert bears == pytest.approx(1.0, rel=1e-3)
    _, rows = recording.energy_arrays()
    kinetic, elastic, _, work, lost, switched = rows.T
    balance = kinetic + elastic - work + lost - switched
    assert balance == pytest.approx(balance[0], abs=1e-5 * np.abs(work).max())


def test_what_a_knot_holds_is_a_part_of_the_strength_of_the_thread():
    limits = []
    for tied in ("square knot", "surgeons knot", "granny knot"):
        compiled, _, outcome = ran(
            knot(
                tied, strength="breaking force = 3 N", body="rupture is allowed", duration="1 s"
            )
        )
        thread = compiled.network.bodies[0].thread
        assert kinds(outcome).count("slip") == 1
        limits.append(outcome.state.springs.strength[thread.hold] / 3.0)
    assert limits == pytest.approx([0.695, 0.668, 0.35])


def test_a_knot_that_takes_the_place_of_another_bears_its_own_part():
    script = "at 0 s: tie sling with granny knot; at 1 ms: tie sling with square knot"
    text = knot(
        script=script,
        strength="breaking force = 3 N",
        body="rupture is allowed",
        duration="2 ms",
    )
    compiled, _, outcome = ran(text)
    thread = compiled.network.bodies[0].thread
    assert outcome.state.springs.strength[thread.hold] == pytest.approx(0.695 * 3.0)


def test_a_thread_breaks_that_is_weaker_than_its_knot():
    text = knot(
        "square knot of 9 N", strength="breaking force = 2 N", body="rupture is allowed"
    )
    _, _, outcome = ran(text)
    assert "rupture" in kinds(outcome) and "slip" not in kinds(outcome)


OPEN = """language 1
tissue silk { spring constant = 1000 N/m; viscosity = 0 N*s/m; mass = 0.5 g }
body cord { mesh is thread { line from (0, 0, 0) mm to (40, 0, 0) mm; pieces = 4
                             thickness = 0.4 mm }; tissue is silk }
set ends = nodes of cord where x < 1 mm or x > 39 mm
set last = nodes of cord where x > 39 mm
set others = nodes of cord where x < 39 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { SCRIPT }
simulate { duration = 0.2 s }
output { length of cord every 10 ms }
"""


def test_the_ends_of_an_open_thread_are_tied_as_they_stand():
    tied = """at 0 s: fix others
      from 0 s to 0.05 s: move last by (-38, 0, 0) mm using smooth profile
      at 0.1 s: tie cord with square knot of 1 N"""
    compiled, recording, outcome = ran(OPEN.replace("SCRIPT", tied))
    thread = compiled.network.bodies[0].thread
    assert outcome.state.alive[thread.hold]
    assert outcome.state.springs.rest[thread.hold] == pytest.approx(2e-3)
    _, length = recording.log_arrays("length of cord")
    assert length[-1] == pytest.approx(30e-3 + 28e-3 + 2e-3)
    assert "note" not in kinds(outcome)


def test_ends_that_are_far_apart_are_tied_with_a_note():
    _, _, outcome = ran(OPEN.replace("SCRIPT", "at 0.1 s: tie cord with granny knot of 1 N"))
    (note,) = [h.cause for _, h in outcome.logged_events if h.kind == "note"]
    assert note == "the ends of cord are 40 mm apart when tied"


@pytest.mark.parametrize(("script", "note"), [
    ("at 0.1 s: tighten cord to 50 mm", "its length is already 40 mm"),
    ("at 0.1 s: loosen cord to 30 mm", "its length is already 40 mm"),
])  # fmt: skip
def test_the_wrong_direction_is_noted_and_changes_nothing(script, note):
    _, _, outcome = ran(OPEN.replace("SCRIPT", script))
    assert note in outcome.logged_events[-1][1].cause
    assert outcome.state.springs.rest[:4] == pytest.approx(np.full(4, 10e-3))


def test_a_later_order_takes_the_place_of_one_under_way():
    script = "from 0 s to 0.2 s: tighten cord to 20 mm; at 0.1 s: loosen cord to 35 mm"
    _, _, outcome = ran(OPEN.replace("SCRIPT", script))
    assert outcome.state.springs.rest[:4].sum() == pytest.approx(35e-3)
    assert not outcome.state.reelings


def test_a_written_rest_length_ends_the_drawing_in():
    script = (
        "from 0 s to 0.2 s: tighten cord to 20 mm; at 0.1 s: change rest length of cord to 9 mm"
    )
    _, _, outcome = ran(OPEN.replace("SCRIPT", script))
    assert outcome.state.springs.rest[:4] == pytest.approx(np.full(4, 9e-3))


def test_only_threads_are_tightened_and_tied():
    text = VESSEL.replace(
        "SCRIPT", "at 0 s: tie vessel with square knot; at 0 s: loosen ends to 1 m"
    )
    with pytest.raises(CompileError) as caught:
        compiled_scene(text.replace("DURATION", "1 s"))
    messages = [d.message for d in caught.value.diagnostics]
    assert messages == [
        "vessel is neither a body with mesh thread nor a joint",
        "ends is neither a body with mesh thread nor a joint",
    ]


def test_snapshots_of_a_batch_have_their_own_rest_lengths():
    compiled, _, outcome = ran(OPEN.replace("SCRIPT", "at 0 s: fix cord"))
    state = outcome.state
    from tissuec.script.verbs.tie import ChangeRestLength  # what the sentence reads to

    compiled = compiled_scene(
        OPEN.replace("SCRIPT", "from 0 s to 0.2 s: tighten cord to 20 mm")
    )
    (event,) = compiled.plan.events
    assert isinstance(event.action, ChangeRestLength)

    class Nothing:
        def add(self, time, action): ...
        def land(self, times): ...

    state.time = 0.0
    event.action.apply(state, Nothing())
    times = np.array([0.0, 0.1, 0.2])
    many = [np.repeat(part[None], 3, axis=0) for part in (state.position, state.velocity)]
    snapshot = Snapshot(state, times, *many, np.zeros(6, dtype=bool))
    assert snapshot.tension[:, 0] == pytest.approx([0.0, 2.5, 5.0])
    assert snapshot.pick(np.array([1, 2])).tension[:, 0] == pytest.approx([2.5, 5.0])
    assert snapshot.energies.elastic == pytest.approx([0.0, 4 * 0.5 * 2.5**2 / 1e3, 0.05])


# --- through surfaces -----------------------------------------------------------------------

SHEET = """language 1
tissue silk {{ spring constant = 1000 N/m; viscosity = 0.5 N*s/m; mass = 0.5 g }}
body sheet {{
  mesh is sheet {{ corner = (-5, -5, 0) mm; first edge = (10, 0, 0) mm
                  second edge = (0, 10, 0) mm; columns = 5; rows = 5; diagonals is one }}
  tissue is silk
}}
body strand {{
  mesh is thread {{ line from (-3, 0.6, 2) mm to (3, 0.6, 4) mm; pieces = 4
                   thickness = 0.4 mm }}
  tissue is silk
}}
{joint}
environment {{ gravity = (0, 0, 0) m/s^2; contact is tools only }}
script {{
  at 0 s: {{ fix sheet; fix strand }}
  from 0 s to 10 ms: move strand by (0, 0, {by}) mm using smooth profile
  from 10 ms to 20 ms: move strand by (0, 0, -0.1) mm using smooth profile
}}
simulate {{ duration = 30 ms }}
"""
SEWN = "joint seam { springs from strand to sheet; reach = 5 mm; tissue is silk }"


@pytest.mark.parametrize(
    ("by", "joint", "noted"), [(-2.8, "", 1), (-1, "", 0), (-2.8, SEWN, 0)]
)
def test_a_thread_that_goes_through_a_surface_is_noted_once(by, joint, noted):
    """Held nodes go where they are moved to, whatever touches them."""
    _, _, outcome = ran(SHEET.format(by=by, joint=joint))
    found = [time for time, note in outcome.logged_events if "passes through" in note.cause]
    assert len(found) == noted
    # The lower end is 2 mm above the sheet: 6 t⁵ - 15 t⁴ + 10 t³ is 2/2.8 there.
    ways = np.roots([6.0, -15.0, 10.0, 0.0, 0.0, -2.0 / 2.8])
    reached = 10e-3 * min(abs(t) for t in ways if abs(t.imag) < 1e-9 and 0.0 < t.real < 1.0)
    assert all(reached < time < reached + 0.5e-3 for time in found)


def test_a_segment_goes_through_a_triangle_where_barycentric_coordinates_say_so():
    random = np.random.default_rng(3)
    segments, triangles = random.normal(size=(60, 2, 3)), random.normal(size=(50, 3, 3))
    found, expected = [], []
    for start, end in segments:
        ends = np.broadcast_to((start, end), (len(triangles), 2, 3))
        found += go_through(ends, triangles).tolist()
        for a, b, c in triangles:
            # start + s (end - start) = a + u (b - a) + v (c - a)
            s, u, v = np.linalg.solve(np.stack([start - end, b - a, c - a], axis=1), start - a)
            expected.append(0.0 < s < 1.0 and min(u, v, 1.0 - u - v) > 0.0)
    assert sum(expected) > 100
    assert found == expected
