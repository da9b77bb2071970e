"""Bodies of elements that break: when, what is booked and told, and what is left."""

import numpy as np
import pytest

import tissuec
from tests.findings import finding_of
from tests.scene.breaking import (
    breaks_alike_when_resumed,
    first_ruptures,
    ruptures,
    the_ledger_closes,
    the_reference_breaks_alike,
)
from tests.whole_runs import carried_out, same_on_threads
from tissuec.core.source import Source
from tissuec.engine.execution.recorder import wishes
from tissuec.engine.stepper import Stepper
from tissuec.pipeline import check_request, compile_request
from tissuec.scene.request import Request

#: Drawn out until all elements between its ends break.
BAR = """\
language 1
tissue gel {{
  Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 5 ms; {limit}
}}
body strip {{
  mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to (20, {width}, 5) mm }}
  tissue is gel; made of elements; rupture is {rupture}; {body}
}}
set low = nodes of strip where x < 0.1 mm
set high = nodes of strip where x > 19.9 mm
set edges = springs of strip where x between 5 mm and 15 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{
  at 0 s: fix low
  from 0 s to {ramp}: move high by (10, 0, 0) mm using smooth profile
  {script}
}}
simulate {{ duration = 0.25 s; {method} }}
output {{ {output} }}
{more}
"""
OUTPUT = "trajectory every 10 ms; energy every 10 ms; ruptured of strip every 10 ms"


def scene(
    limit="breaking strain = 30 %",
    *,
    rupture="allowed",
    width=5,
    body="",
    script="",
    output=OUTPUT,
    method="",
    ramp="0.2 s",
    more="",
):
    text = BAR.format(
        limit=limit, rupture=rupture, width=width, body=body, script=script, output=output,
        method=method, ramp=ramp, more=more,
    )  # fmt: skip
    return Request(Source("bar.tis", text))


def compiled(limit="breaking strain = 30 %", **parts):
    return compile_request(scene(limit, **parts))[0]


# --- when -------------------------------------------------------------------------------------


def drawn_evenly(cells, limit, law=""):
    """Return a scene of a cube whose layers are drawn apart evenly, to twice its height."""
    side = 20.0 / cells
    lines = [
        f"set s{k} = nodes of cube where z between {side * k - 0.1} mm and {side * k + 0.1} mm"
        for k in range(cells + 1)
    ]
    moves = [
        f"from 0 s to 1 s: move s{k} by (0, 0, {side * k}) mm using constant speed"
        for k in range(1, cells + 1)
    ]
    return "\n".join(
        [
            "language 1",
            f"tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = 0.3; {law}",
            f"density = 1000 kg/m^3; {limit} }}",
            f"body cube {{ mesh is lattice {{ cell = {side} mm",
            "box from (0, 0, 0) mm to (20, 20, 20) mm }",
            "tissue is gel; made of elements; rupture is allowed }",
            *lines,
            "environment { gravity = (0, 0, 0) m/s^2 }",
            "script {",
            "at 0 s: fix s0",
            *moves,
            "}",
            "simulate { duration = 1 s }",
        ]
    )


def breaks(text):
    outcome, _ = carried_out(compile_request(Request(Source("cube.tis", text)))[0])
    return ruptures(outcome)


@pytest.mark.parametrize("cells", [1, 4])
def test_all_elements_of_a_cube_break_at_its_breaking_strain(cells):
    ((time, event),) = breaks(drawn_evenly(cells, "breaking strain = 30 %"))
    assert time == pytest.approx(0.3, rel=1e-9)
    # Every element, and the edges that none has any more.
    assert len(event.springs) == cells**3 + 3 * cells * (cells + 1) ** 2


def stress_at(stretch, steep=1.0):
    """Return the stress along the cube of ``drawn_evenly`` at a stretch [Pa].

    Args:
        steep: How many times as large as that of a neo-Hookean law its slope is.
    """
    # The sides do not move: σ = μ g (λ² - I1/3)/λ 2 ψ' + K ln J/J, with J = λ.
    shear, bulk = 10e3 / 2.6, 10e3 / 1.2
    stress = shear * steep * stretch ** (-2.0 / 3.0) * (stretch**2 - (stretch**2 + 2.0) / 3.0)
    return float(stress / stretch + bulk * np.log(stretch) / stretch)


@pytest.mark.parametrize("cells", [1, 4])
@pytest.mark.parametrize("law", ["", "solid law is exponential { stiffening = 2 };"])
def test_all_elements_of_a_cube_break_at_its_strength(cells, law):
    along = 1.4
    first = along ** (-2.0 / 3.0) * (along**2 + 2.0)
    steep = np.exp(2.0 * (first - 3.0)) if law else 1.0
    strength = f"strength = {stress_at(along, steep)!r} Pa"
    ((time, event),) = breaks(drawn_evenly(cells, strength, law))
    assert time == pytest.approx(along - 1.0, rel=1e-9)
    assert "exceeded the strength" in event.cause


# --- what is booked ---------------------------------------------------------------------------


@pytest.mark.parametrize(
    "limit",
    ["breaking strain = 30 %", "strength = 3 kPa", "toughness = 4 J/m^2"],
    ids=lambda text: text.split(" =")[0],
)
def test_the_ledger_closes_over_ruptures(limit):
    _, recording = carried_out(compiled(limit))
    the_ledger_closes(recording)


def test_the_energy_of_elements_that_break_is_lost():
    outcome, recording = carried_out(compiled())
    _, rows = recording.energy_arrays()
    state = outcome.state
    assert rows[-1, 5] == pytest.approx(-_energy_at_break(), rel=1e-4)
    assert (~state.alive).any()


def _energy_at_break():
    """Return the energy that broken elements held, from runs that end just before that."""
    outcome, _ = carried_out(compiled())
    total = 0.0
    for time, _ in ruptures(outcome):
        found = compiled(script=f"at {time - 1e-9} s: end the run")
        before, _ = carried_out(found)
        (field,) = found.network.of_kind("elements")
        loads = field.breakable.loads(before.state.position)
        breaking = np.abs(loads - 1.0) < 1e-4
        assert breaking.sum() == 1
        total += field.energies(before.state.position)[breaking].sum()
    return total


# --- what is told and left --------------------------------------------------------------------


def test_elements_that_break_are_told_by_number_place_and_line():
    outcome, _ = carried_out(compiled())
    found = ruptures(outcome)
    assert len(found) == 2
    _, event = found[0]
    assert event.cause == (
        "the strain of element 2 of strip around (7.5 mm, 2.5 mm, 2.5 mm) exceeded the "
        "breaking strain"
    ) or event.cause == (
        "the strain of element 3 of strip around (12.5 mm, 2.5 mm, 2.5 mm) exceeded the "
        "breaking strain"
    )
    assert event.span.text == "breaking strain = 30 %"


CONDITIONS = """
expect ruptured(strip) == 0 and count(elements of strip) == 4 at 0.1 s
expect ruptured(strip) == 2 and count(elements of strip) == 2 at 0.2 s
expect count(pieces of strip) == 6 and count(springs of strip) == 24 at 0.25 s
expect ruptured(low) == 0 and ruptured(edges) == 12 at 0.25 s
"""


def test_conditions_count_what_broke():
    found = compiled(
        script="when ruptured(strip): change gravity to (0, 0, 0) m/s^2",
        more=CONDITIONS,
    )
    outcome, _ = carried_out(found)
    assert not (outcome.failures or outcome.unreached)
    times = [t for t, e in outcome.logged_events if e.kind in ("rupture", "trigger")]
    assert times[0] == times[1]  # the condition is true at once


def test_elements_are_no_springs():
    found, plain = compiled(), compiled(rupture="not allowed", output="energy every 10 ms")
    network = found.network
    assert (network.spring_count, network.line_count, network.entity_count) == (0, 36, 36 + 4)
    assert network.size == plain.network.size
    assert wishes(network, found.plan).lines.tolist() == list(range(36))
    groups = {group.name: group.indices for group in found.named_groups()}
    assert groups["edges"].max() < 36
    assert found.springs_of("strip").tolist() == list(range(36))
    assert found.springs_of("low").max() < 36
    assert network.owner(37).name == "strip"
    assert network.elements_within(np.arange(network.node_count)).tolist() == [36, 37, 38, 39]


def test_a_result_keeps_which_elements_broke(tmp_path):
    path = tmp_path / "bar.vtkhdf"
    text = scene(more="expect ruptured(edges) == 12 at 0.25 s").source.text
    with tissuec.run(text, out=path, companion="off") as result:
        assert result.finished
    with tissuec.load(path) as result:
        network = result.network
        assert [(b.name, b.elements) for b in network.bodies] == [("strip", slice(36, 40))]
        broken = [e for e in result.events if e.kind == "rupture"]
        elements = {s for e in broken for s in e.springs if s >= network.line_count}
        assert elements == {37, 38}
        # 16 triangles around the sides of both, beside those of the two that are left.
        first, last = result.cells(0), result.cells(len(result.times) - 1)
        assert len(first.triangles) - len(last.triangles) == 16
        assert len(first.lines) - len(last.lines) == 12
        assert len(last.vertices) == 4  # nodes between both, which nothing holds any more


# --- what changes nothing ---------------------------------------------------------------------


def test_a_run_that_is_resumed_gives_the_same_bytes():
    breaks_alike_when_resumed(compiled())


@pytest.mark.parametrize(
    "method",
    [
        "dop853",
        "esdirk43",
        *(pytest.param(m, marks=pytest.mark.slow) for m in ("velocity verlet", "rkc2")),
    ],
)
def test_what_is_observed_changes_nothing(method):
    entry = f"integrator is {method}"
    times, ends = [], []
    for output, script in (
        (OUTPUT, ""),
        ("force of high every 0.1 ms; trajectory every 0.2 ms", ""),
        ("energy every 50 ms", "when gap(strip) > 30 m: end the run"),
    ):
        outcome, _ = carried_out(compiled(output=output, script=script, method=entry))
        times.append([t for t, _ in ruptures(outcome)])
        ends.append(outcome.state.position)
    assert len(times[0]) >= 2
    assert times[0] == times[1] == times[2]
    assert np.array_equal(ends[0], ends[1])
    assert np.array_equal(ends[0], ends[2])


def test_how_long_calls_take_changes_nothing(monkeypatch):
    """Steps that are made again use the factor that they used first."""
    ends = []
    for most in (1, 40, 100_000):
        monkeypatch.setattr(Stepper, "call_limit", lambda self, _, most=most: self.asked + most)
        outcome, _ = carried_out(compiled(output=OUTPUT, method="integrator is esdirk43"))
        ends.append((ruptures(outcome), outcome.state.position))
    assert len(ends[0][0]) >= 2
    for found, position in ends[1:]:
        assert [time for time, _ in found] == [time for time, _ in ends[0][0]]
        assert np.array_equal(position, ends[0][1])


def test_methods_agree_on_the_time_of_ruptures():
    assert np.ptp(first_ruptures(compiled)) < 1e-5


def test_elements_break_at_rest_too():
    found = compiled(
        method="integrator is relaxation; step = 20 ms", output="energy every 20 ms",
        script="at 0.12 s: end the run",
    )  # fmt: skip
    outcome, _ = carried_out(found)
    times = [t for t, _ in ruptures(outcome)]
    (field,) = found.network.of_kind("elements")
    assert outcome.kind == "done"
    assert times and all(round(t / 2e-2) == pytest.approx(t / 2e-2) for t in times)
    assert len(field.lost_items(outcome.state.alive)) >= 1


def test_the_reference_breaks_the_same_elements_at_the_same_times():
    found = compiled(script="at 8 ms: end the run", ramp="14 ms", output="energy every 1 ms")
    ruptured = the_reference_breaks_alike(found)
    assert ruptured.run == 1 and ruptured.error < 1e-7


#: Large enough for several threads.
BLOCK = """\
language 1
tissue gel {
  Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 2 ms
  breaking strain is none
}
tissue weak like gel { breaking strain = 1 % }
body block {
  mesh is lattice { cell = 2 mm; box from (0, 0, 0) mm to (48, 48, 14) mm }
  tissue is gel; rupture is allowed
  region corner where x > 45 mm and y < 3 mm { tissue is weak }
}
set high = nodes of block where x > 47.9 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { from 0 s to 5 ms: move high by (2, 0, 0) mm using smooth profile }
simulate { duration = 1 ms }
output { trajectory every 0.2 ms; energy every 0.2 ms }
"""


@pytest.mark.slow
def test_threads_break_the_same_elements_at_the_same_times(threads_in_small_nets):
    one = same_on_threads(BLOCK, 2, 3)
    broken = [event for event in one.events if event.kind == "rupture"]
    assert len(broken) > 1


# --- bad input --------------------------------------------------------------------------------


def refusal(limit, **parts):
    found = finding_of(compile_request, scene(limit, **parts))
    return f"{found.code}: {found.message}", found.hint


def test_limits_of_springs_are_refused():
    message, hint = refusal("breaking force = 1 N")
    assert message == (
        "TIS306: the breaking force of each spring is not available for elements"
    )
    assert hint == "write a breaking strain, a strength or a toughness in the tissue instead"
    message, _ = refusal("breaking strain = 30 %; crushing force = 1 N")
    assert message == "TIS306: a crushing force is not available for elements"


def test_what_may_rupture_needs_a_limit():
    message, hint = refusal("")
    assert message == (
        "TIS206: the breaking strain of tissue gel is missing: neither a rule nor a number "
        "gives it"
    )
    assert "breaking strain = … in the tissue" in hint


def test_no_limit_can_be_written():
    found = compiled("breaking strain is none")
    assert not found.plan.breakable


def warnings(limit, **parts):
    _, found = check_request(scene(limit, **parts))
    return {one.code: one for one in found}


def test_ruptures_of_what_cannot_rupture_are_reported():
    found = warnings("breaking strain = 30 %", rupture="not allowed")["W404"]
    assert found.message == "nothing in strip can rupture, so this is always 0"
    assert found.hint == "write rupture is allowed instead"
    found = warnings("breaking strain is none")["W404"]
    assert "the tissue has no breaking force or strain" in found.message
    assert "W404" not in warnings("breaking strain = 30 %")


def test_a_limit_that_is_set_of_what_cannot_rupture_is_reported():
    entry = "strength of gel = 5 kPa"
    text = BAR.format(
        limit="", rupture="not allowed", width=5, body="", script="", method="", ramp="0.2 s",
        output="force(high) every 1 ms", more="",
    ).replace("rupture is not allowed;", "")  # fmt: skip
    found = check_request(Request(Source("bar.tis", text), overrides=(entry,)))[1]
    assert ("W404", entry) in [(one.code, one.span.one_line) for one in found]


def test_strains_that_no_tissue_bears_are_reported():
    found = warnings("breaking strain = 30")["W209"]
    assert found.message == "elements of strip break only at 31 times their length"
    assert found.hint == "is a strain of 3000 % meant? otherwise write breaking strain = 30 %"


def test_a_cut_at_the_start_is_no_cut_of_nothing():
    blade = "at 0 s: cut strip along plane through (7, 0, 0) mm facing (1, 0, 0)"
    assert "W410" not in warnings("breaking strain = 30 %", script=blade)


@pytest.mark.parametrize("name", ["breaking force", "spring constant", "rest length"])
def test_what_only_springs_have_cannot_be_changed(name):
    given = "by 2" if name != "breaking force" else "to 2 N"
    message, _ = refusal(
        "breaking strain = 30 %", script=f"at 1 ms: change {name} of strip {given}"
    )
    assert message == (
        f"TIS309: strip consists of elements; their edges have no {name}, so that this changes "
        "nothing"
    )


def test_explain_says_how_far_elements_stretch_until_they_break():
    used = "expect not ruptured(edges) at 0 s"
    (found,) = tissuec.properties(scene(more=used).source.text)
    assert found.breaking.stretch == pytest.approx((1.3, 1.3, 1.3))
    (found,) = tissuec.properties(scene("toughness = 4 J/m^2", more=used).source.text)
    assert found.breaking is None
