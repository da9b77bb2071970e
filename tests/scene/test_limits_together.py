"""A breaking strain and a strength together, and a toughness beside them."""

import numpy as np
import pytest

import tissuec
from tests.findings import finding_of
from tests.matter.test_bodies import THREAD, text_of
from tests.scene.breaking import ruptures, the_reference_breaks_alike
from tests.scene.test_breaking_elements import (
    breaks,
    compiled,
    drawn_evenly,
    scene,
    stress_at,
)
from tests.scene.test_breaking_walls import compiled as wall
from tests.whole_runs import carried_out
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.pipeline import compile_request, read_words
from tissuec.scene.request import Request

MATTER = "Young's modulus = 5 kPa; density = 1000 kg/m^3; retardation time = 1 ms"
STRAIN, STRESS = "breaking strain = 40 %", "strength = 1.5 kPa"

# --- elements ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("strain", "stress", "first"),
    [(0.3, 0.4, "breaking strain"), (0.4, 0.3, "strength"), (0.3, 0.9, "breaking strain")],
)
@pytest.mark.parametrize("order", [1, -1])
def test_an_element_breaks_at_whichever_is_reached_first(strain, stress, first, order):
    limits = [f"breaking strain = {strain!r}", f"strength = {stress_at(1.0 + stress)!r} Pa"]
    ((time, event),) = breaks(drawn_evenly(1, "; ".join(limits[::order])))
    assert time == pytest.approx(min(strain, stress), rel=1e-9)
    assert event.cause.endswith(f"exceeded the {first}")
    assert event.span.text.startswith(first)


def test_a_wall_breaks_at_whichever_is_reached_first():
    def broken(limit):
        outcome, _ = carried_out(wall(limit, tough="breaking strain is none"))
        return ruptures(outcome)[0]

    strain, stress = (broken(one) for one in ("breaking strain = 20 %", "strength = 2 kPa"))
    assert strain[0] != stress[0]
    earlier, later = sorted([strain, stress], key=lambda one: one[0])
    time, event = broken("breaking strain = 20 %; strength = 2 kPa")
    assert time == pytest.approx(earlier[0], rel=1e-6)
    assert event.cause == earlier[1].cause and event.cause != later[1].cause


def test_the_reference_breaks_the_same_elements_by_both():
    both = "breaking strain = 30 %; strength = 2.4 kPa"
    found = compiled(
        both, script="at 9 ms: end the run", ramp="14 ms", output="energy every 1 ms"
    )
    the_reference_breaks_alike(found)


# --- bars -------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", ["", "stiffening = 6; "])
def test_bars_break_at_the_smaller_force(law):
    def strength(limit):
        text = text_of(THREAD, f"{MATTER}; {law}{limit}", "rupture is allowed")
        network = tissuec.compile(text).network
        return network.springs.strength, network.provenance["strength"]

    (strain, _), (stress, _), (both, known) = map(
        strength, (STRAIN, STRESS, f"{STRAIN}; {STRESS}")
    )
    np.testing.assert_array_equal(both, np.minimum(strain, stress))
    smaller = np.flatnonzero(np.isfinite(both))
    for spring in (smaller[0], smaller[-1]):
        text = known[int(spring)].span.text
        assert text == (STRAIN if strain[spring] <= stress[spring] else STRESS)


# --- by toughness -----------------------------------------------------------------------------


def test_a_toughness_counts_alone_or_where_the_body_breaks_by_it():
    alone, beside = "toughness = 4 J/m^2", f"toughness = 4 J/m^2; {STRAIN}; {STRESS}"

    def limits(limit, rupture):
        text = scene(limit).source.text.replace("rupture is allowed", rupture)
        (field,) = compile_request(Request(Source("x.tis", text)))[0].network.elements
        known = field.limits
        return [one[0] for one in (known.strain, known.stress, known.toughness)]

    by_toughness = limits(alone, "rupture is allowed")
    assert np.isinf(by_toughness[:2]).all() and np.isfinite(by_toughness[2])
    assert limits(beside, "rupture by toughness") == by_toughness
    assert limits(beside, "rupture is allowed") == [0.4, 1500.0, np.inf]


def test_bars_break_by_toughness_too():
    def strength(limit, rupture):
        text = text_of(THREAD, f"{MATTER}; {limit}", rupture)
        return tissuec.compile(text).network.springs.strength

    alone = strength("toughness = 4 J/m^2", "rupture is allowed")
    beside = strength(f"toughness = 4 J/m^2; {STRAIN}", "rupture by toughness")
    np.testing.assert_array_equal(alone, beside)


def test_a_body_that_breaks_by_toughness_needs_one():
    text = scene(STRAIN).source.text.replace("rupture is allowed", "rupture by toughness")
    found = finding_of(compile_request, Request(Source("x.tis", text)))
    assert found.code == "TIS206"
    assert found.message.startswith("the toughness of tissue gel is missing")


# --- words, parents and children --------------------------------------------------------------

WORDS = """language 1
property grip from 0 to 1 { evenly = [loose, tight] }
quantity breaking strain from 1 % to 100 % on log scale { evenly = [low, high] }
quantity strength from 1 kPa to 1 MPa on log scale { evenly = [low, high] }
quantity toughness from 1 J/m^2 to 1 kJ/m^2 on log scale { evenly = [low, high] }
rules r {
  if grip is loose then breaking strain is low and strength is low and toughness is low
  if grip is tight then breaking strain is high and strength is high and toughness is high
}
tissue band { described in r; grip is tight; density = 1 g/cm^3 }
tissue bare { density = 1 g/cm^3 }
"""


def given(text, name="own"):
    """Return the limits of a tissue, and which of them are written."""
    tissues = read_words(Request(Source("x.tis", f"{WORDS}{text}", None)))[0].tissues
    limits = ("breaking force", "breaking strain", "strength", "toughness")
    found = tissues[name].given
    return {key: found[key].how for key in limits if key in found}


def test_rules_conclude_all_together():
    assert given("", "band") == dict.fromkeys(
        ("breaking strain", "strength", "toughness"), "rules"
    )


@pytest.mark.parametrize(
    ("written", "left"),
    [
        (STRAIN, {"breaking strain": "written", "toughness": "rules"}),
        (STRESS, {"strength": "written", "toughness": "rules"}),
        ("toughness = 4 J/m^2", {"toughness": "written"}),
        ("breaking strain is none", {"breaking strain": "written"}),
        ("breaking force = 1 N", {"breaking force": "written"}),
        (f"{STRAIN}; {STRESS}",
         {"breaking strain": "written", "strength": "written", "toughness": "rules"}),
    ],
)  # fmt: skip
def test_what_is_written_takes_the_place_of_what_rules_conclude(written, left):
    assert given(f"tissue own like band {{ {written} }}") == left


PARENT = f"tissue old like bare {{ {STRAIN}; {STRESS}; toughness = 4 J/m^2 }}\n"


@pytest.mark.parametrize(
    ("written", "left"),
    [
        ("", {"breaking strain", "strength", "toughness"}),
        ("breaking strain = 10 %", {"breaking strain", "toughness"}),
        ("strength = 1 kPa", {"strength", "toughness"}),
        (
            "strength = 1 kPa; breaking strain = 10 %",
            {"breaking strain", "strength", "toughness"},
        ),
        ("toughness = 5 J/m^2", {"toughness"}),
        ("strength is none", {"strength"}),
        ("breaking force = 1 N", {"breaking force"}),
    ],
)
def test_a_child_replaces_what_it_inherits(written, left):
    assert set(given(f"{PARENT}tissue own like old {{ {written} }}")) == left


def test_a_force_of_springs_stands_beside_none_of_them():
    for other in (STRAIN, STRESS, "toughness = 4 J/m^2"):
        with pytest.raises(CompileError) as caught:
            given(f"tissue own {{ breaking force = 1 N; {other} }}")
        assert caught.value.diagnostics[0].code == "TIS306"


def test_without_a_strain_a_toughness_counts():
    text = scene("breaking strain is none; toughness = 4 J/m^2").source.text
    (field,) = compile_request(Request(Source("x.tis", text)))[0].network.elements
    assert np.isfinite(field.limits.toughness).all()
