"""Walls of elements that break: limits, the effects of a broken triangle, and reports."""

import numpy as np
import pytest

import tissuec
from tests.scene.breaking import (
    breaks_alike_when_resumed,
    first_ruptures,
    ruptures,
    the_ledger_closes,
    the_reference_breaks_alike,
)
from tests.whole_runs import carried_out, same_on_threads
from tissuec.core.source import Source
from tissuec.pipeline import check_request, compile_request
from tissuec.scene.request import Request

#: The middle is weaker, and breaks at once.
STRIP = """\
language 1
tissue skin {{
  Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 2 ms; {limit}
}}
tissue tough like skin {{ {tough} }}
body strip {{
  mesh is sheet {{
    corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = (0, 10, 0) mm
    columns = 9; rows = 3
  }}
  tissue is tough; thickness = 1 mm; rupture is {rupture}; {body}
  region middle where x between 15 mm and 20 mm {{ tissue is skin }}
}}
set low = nodes of strip where x < 0.1 mm
set high = nodes of strip where x > 39.9 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{
  at 0 s: fix low
  from 0 s to {ramp}: move high by (12, 0, 0) mm using smooth profile
  {script}
}}
simulate {{ duration = {duration}; {method} }}
output {{ {output} }}
{more}
"""
OUTPUT = "trajectory every 5 ms; energy every 5 ms; ruptured of strip every 5 ms"


def scene(
    limit="breaking strain = 20 %",
    *,
    tough="",
    rupture="allowed",
    body="",
    script="",
    output=OUTPUT,
    method="",
    ramp="0.1 s",
    duration="0.12 s",
    more="",
):
    name, number, *unit = limit.replace("= ", "").rsplit(" ", 2)
    stronger = " ".join([name, "=", str(10.0 * float(number)), *unit])
    text = STRIP.format(
        limit=limit, tough=tough or stronger, rupture=rupture, body=body, script=script,
        output=output, method=method, ramp=ramp, duration=duration, more=more,
    )  # fmt: skip
    return Request(Source("strip.tis", text))


def compiled(limit="breaking strain = 20 %", **parts):
    return compile_request(scene(limit, **parts))[0]


# --- when -------------------------------------------------------------------------------------

#: A square that becomes longer and wider evenly.
SQUARE = """\
language 1
tissue skin {{ Young's modulus = 10 kPa; Poisson's ratio = {ratio}; density = 1000 kg/m^3
  {limit} }}
body square {{
  mesh is sheet {{
    corner = (0, 0, 0) mm; first edge = (8, 0, 0) mm; second edge = (0, 8, 0) mm
    columns = {count}; rows = {count}
  }}
  tissue is skin; thickness = 1 mm; rupture is allowed
}}
{sets}
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ {moves} }}
simulate {{ duration = 1 s }}
"""


def drawn_evenly(limit, ratio=0.3, cells=2):
    sets, moves = [], []
    for i in range(cells + 1):
        for j in range(cells + 1):
            x, y = 8.0 * i / cells, 8.0 * j / cells
            sets.append(
                f"set s{i}{j} = nodes of square where x between {x - 0.1} mm and {x + 0.1} mm "
                f"and y between {y - 0.1} mm and {y + 0.1} mm"
            )
            moves.append(
                f"from 0 s to 1 s: move s{i}{j} by ({x}, {y}, 0) mm using constant speed"
            )
    text = SQUARE.format(
        limit=limit, ratio=ratio, count=cells + 1, sets="\n".join(sets),
        moves="\n".join(moves),
    )  # fmt: skip
    return ruptures(carried_out(compile_request(Request(Source("s.tis", text)))[0])[0])


def test_all_triangles_of_a_square_break_at_its_breaking_strain():
    ((time, event),) = drawn_evenly("breaking strain = 30 %")
    assert time == pytest.approx(0.3, rel=1e-9)
    assert len(event.springs) == 8 + 16  # every triangle and every edge


def test_all_triangles_of_a_square_break_at_its_strength():
    # σ = μ (λ² - λ⁻⁴)/λ per drawn section of an incompressible wall.
    shear, along = 10e3 / 2.9998, 1.4
    stress = shear * (along - along**-5)
    ((time, event),) = drawn_evenly(f"strength = {stress} Pa", ratio=0.4999)
    assert time == pytest.approx(along - 1.0, rel=1e-3)
    assert "exceeded the strength" in event.cause


# --- what is lost -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "limit",
    ["breaking strain = 20 %", "strength = 2 kPa", "toughness = 2 J/m^2"],
    ids=lambda text: text.split(" =")[0],
)
def test_the_ledger_closes_over_ruptures(limit):
    outcome, recording = carried_out(compiled(limit))
    assert ruptures(outcome)
    the_ledger_closes(recording)


def test_a_triangle_that_breaks_loses_its_stress_and_its_bending():
    found = compiled()
    outcome, _ = carried_out(found)
    network, alive = found.network, outcome.state.alive
    (wall,), (plates,) = network.of_kind("membranes"), network.of_kind("plates")
    broken = np.flatnonzero(~alive[wall.walls])
    middle = network.position[wall.nodes][..., 0].mean(axis=1)
    assert broken.tolist() == np.flatnonzero((middle > 15e-3) & (middle < 20e-3)).tolist()
    assert wall.lost_items(alive).tolist() == broken.tolist()
    # Bending is lost with patches: those of broken triangles and of their neighbours.
    near = np.isin(np.sort(plates.nodes, axis=1), wall.nodes[broken]).sum(axis=1)
    lost = plates.lost_items(alive)
    assert set(broken) < set(lost) and (near[lost] >= 2).all()
    # Nothing pulls the halves together any more.
    state, there = outcome.state, np.zeros_like(network.position)
    for field in state.fields:
        field.add_forces(0.0, state.position, 0.0 * there, there)
    left = network.position[:, 0] < 16e-3
    assert np.abs(there[left].sum(axis=0)).max() < 1e-12 * np.abs(there).max()


MORE = """
expect ruptured(strip) == 0 and count(elements of strip) == 32 at 20 ms
expect ruptured(strip) == 4 and count(elements of strip) == 28 at 0.12 s
expect count(pieces of strip) == 2 at 0.12 s
"""


def test_triangles_that_break_are_told_and_counted():
    found = compiled(
        more=MORE, script="when ruptured(strip): change gravity to (0, 0, 0) m/s^2"
    )
    outcome, _ = carried_out(found)
    assert not (outcome.failures or outcome.unreached)
    told = ruptures(outcome)
    assert told[0][1].cause.startswith(
        ("the strain of element ", "the strain of 2 elements", "the strain of 4 elements")
    )
    assert " of strip around (" in told[0][1].cause
    assert told[0][1].cause.endswith("breaking strain") or ", first " in told[0][1].cause
    assert told[0][1].span.text == "breaking strain = 20 %"


def test_pictures_and_results_show_the_wall_torn(tmp_path):
    path = tmp_path / "strip.vtkhdf"
    with tissuec.run(scene().source.text, out=path, companion="off") as result:
        assert result.finished
    with tissuec.load(path) as result:
        first, last = result.cells(0), result.cells(len(result.times) - 1)
        assert (len(first.triangles), len(last.triangles)) == (32, 28)
        # Edges between two broken triangles, and on the rim beside one.
        assert len(first.lines) - len(last.lines) == 5


#: A single triangle in the middle of a wall breaks: all of its edges belong to others, too.
HOLE = """\
language 1
tissue skin { Young's modulus = 100 kPa; density = 1000 kg/m^3; retardation time = 1 ms
  breaking strain is none }
tissue weak like skin { breaking strain = 0.01 % }
body ball {
  mesh is sphere { centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 2 }
  tissue is skin; thickness = 0.5 mm; rupture is allowed
  region spot where x > 9.6 mm and y > -0.1 mm and z between -0.1 mm and 0.1 mm {
    tissue is weak
  }
}
environment { gravity = (0, 0, 0) m/s^2; contact is bodies too; friction = 0 }
script { at 0 s: preserve volume of ball with 100 kPa
  at 0 s: inflate ball to 4.2 ml }
simulate { duration = 2 ms }
output { pressure of ball every 0.2 ms }
"""


def test_a_ball_with_a_hole_leaks_and_nothing_touches_it_there():
    found = compile_request(Request(Source("ball.tis", HOLE)))[0]
    outcome, _ = carried_out(found)
    state, network = outcome.state, found.network
    (wall,) = network.of_kind("membranes")
    broken = np.flatnonzero(~state.alive[wall.walls])
    assert len(broken) == 1
    assert state.alive_springs.all()  # no edge is lost
    # Bending is lost with it and its three neighbours.
    (plates,) = network.of_kind("plates")
    shared = np.isin(wall.nodes, wall.nodes[broken]).sum(axis=1)
    assert plates.lost_items(state.alive).tolist() == np.flatnonzero(shared >= 2).tolist()
    assert state.enclosure("ball") is None
    assert any(event.kind == "leak" for _, event in outcome.logged_events)
    contact = network.contact.intact(state.alive)
    assert np.flatnonzero(~contact.whole).tolist() == broken.tolist()


# --- what changes nothing ---------------------------------------------------------------------


def test_a_run_that_is_resumed_gives_the_same_bytes():
    breaks_alike_when_resumed(compiled())


def test_methods_agree_on_the_time_of_ruptures():
    assert np.ptp(first_ruptures(compiled)) < 1e-5


@pytest.mark.slow  # loads are compared in tests/forces, and elements that break below
def test_the_reference_breaks_the_same_triangles_at_the_same_times():
    found = compiled(ramp="30 ms", duration="20 ms", output="energy every 5 ms")
    assert the_reference_breaks_alike(found).error < 1e-6


#: Large enough for several threads.
CLOTH = """\
language 1
tissue cloth { Young's modulus = 30 kPa; density = 1 g/cm^3; retardation time = 1 ms
  breaking strain is none }
tissue weak like cloth { breaking strain = 0.2 % }
body wall {
  mesh is sheet {
    corner = (0, 0, 0) cm; first edge = (35, 0, 0) cm; second edge = (0, 35, 0) cm
    columns = 72; rows = 72
  }
  tissue is cloth; thickness = 2 mm; rupture is allowed
  region seam where x > 340 mm and y < 50 mm { tissue is weak }
}
set rim = nodes of wall where x < 1 mm
set tip = nodes of wall where x > 349 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix rim; from 0 s to 2 ms: move tip by (2, 0, 0) mm using smooth profile }
simulate { duration = 1 ms }
output { trajectory every 0.2 ms; energy every 0.2 ms }
"""


@pytest.mark.slow
def test_threads_break_the_same_triangles_at_the_same_times(threads_in_small_nets):
    one = same_on_threads(CLOTH, 2, 3)
    assert len([event for event in one.events if event.kind == "rupture"]) > 1


# --- what is said before ----------------------------------------------------------------------


def test_explain_says_how_far_walls_stretch_until_they_break():
    (found,) = tissuec.properties(scene(tough="breaking strain = 40 %").source.text)
    assert found.breaking.stretch == pytest.approx((1.2, 1.4, 1.4))


def test_ruptures_of_what_cannot_rupture_are_reported():
    def codes(limit, **parts):
        return {one.code for one in check_request(scene(limit, **parts))[1]}

    assert "W404" in codes("breaking strain = 20 %", rupture="not allowed")
    assert "W404" not in codes("breaking strain = 20 %")
    assert "W209" in codes("breaking strain = 20 %", tough="breaking strain = 30")
