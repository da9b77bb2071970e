"""Evidence of a tissue: what is known, whom it is inherited from, and what contradicts it."""

import numpy as np
import pytest

from tissuec.compiler.provenance import as_dict, cited, tissue_rows
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.pipeline import read_words
from tissuec.scene.request import Request

LIVER = """
  Young's modulus = 5.5 kPa
  density = 1060 kg/m^3
  known Young's modulus from 3 kPa to 7 kPa by "A"
  known Young's modulus from 5 kPa to 9 kPa by unverified "B"
  known density = 1.06 g/cm^3 by "C"
"""


def read(*tissues):
    return read_words(Request(Source("t.tis", "\n".join(["language 1", *tissues]))))


def codes(*tissues):
    """Return the codes that are told about tissues, errors and warnings."""
    try:
        _, diagnostics = read(*tissues)
    except CompileError as error:
        diagnostics = error.diagnostics
    return [one.code for one in diagnostics]


def test_evidence_is_kept_with_its_source_in_si_units():
    words, warnings = read(f"tissue liver {{ {LIVER} }}")
    first, second, third = words.tissues["liver"].known
    assert not warnings
    assert (first.low, first.high, first.source, first.is_verified) == (3e3, 7e3, "A", True)
    assert not second.is_verified
    # A single number stands for 5 % around it.
    assert (third.low, third.high) == pytest.approx((0.95 * 1060, 1.05 * 1060), rel=1e-12)


def test_a_child_inherits_what_it_has_no_evidence_of_its_own_for():
    words, _ = read(
        f"tissue liver {{ {LIVER} }}",
        "tissue scar like liver { Young's modulus = 25 kPa; "
        'known Young\'s modulus from 20 kPa to 30 kPa by "D" }',
    )
    known = words.tissues["scar"].known
    assert [(one.quantity.name, one.source) for one in known] == [
        ("Young's modulus", "D"),
        ("density", "C"),
    ]
    assert len(words.tissues["liver"].known) == 3


@pytest.mark.parametrize(
    ("entry", "told"),
    [
        ("Young's modulus = 5 kPa", []),
        ("Young's modulus = 9 kPa", []),  # limits belong to a range
        ("Young's modulus = 9.01 kPa", ["W208"]),
        ("Young's modulus = 4.99 kPa", ["W208"]),
        ("spring constant = 5 N/m", []),
    ],
)
def test_a_number_is_told_where_it_lies_outside_of_what_is_known(entry, told):
    assert (
        codes(f'tissue t {{ {entry}; known Young\'s modulus from 5 kPa to 9 kPa by "A" }}')
        == told
    )


# The middle one has something in common with both others, which have nothing with each other.
@pytest.mark.parametrize("second", ["from 5 kPa to 9 kPa", "= 7.3 kPa"])
def test_evidence_has_to_leave_a_number(second):
    ranges = ("from 3 kPa to 7 kPa", second, "from 8 kPa to 9 kPa")
    known = [f'known strength {one} by "{n}"' for n, one in enumerate(ranges)]
    assert codes(f"tissue t {{ {'; '.join(known[:2])} }}") == []
    assert codes(f"tissue t {{ {'; '.join(known)} }}") == ["TIS207"]


def test_explain_names_evidence_and_its_sources():
    words, _ = read(f"tissue liver {{ {LIVER} }}")
    liver = words.tissues["liver"]
    rows = [(row.name, row.value, row.how) for row in tissue_rows(liver) if row.kind == "known"]
    assert rows[1] == ("known Young's modulus", "5 kPa to 9 kPa", "B (unverified)")
    assert cited(liver.known[0]) == "A"
    plain = as_dict(words, [liver])["tissues"]["liver"]["known"]
    assert [one["verified"] for one in plain] == [True, False, True]


# --- curves -----------------------------------------------------------------------------------

CURVES = """
  Young's modulus = 5.5 kPa
  known stress in tension at [10 %, 30 %] from [1 kPa, 3 kPa] to [2 kPa, 8000 Pa] by "A"
  known stress in tension at 20 % from 2 kPa to 4 kPa by unverified "B"
  known stress in equibiaxial tension at [0.1] from [2 kPa] to [4 kPa] by "A"
  known relaxation at [1 s, 1 min] from [70 %, 0.5] to [80 %, 0.6] by "C"
"""


def test_curves_are_kept_with_their_sources_in_si_units():
    words, warnings = read(f"tissue liver {{ {CURVES} }}")
    first, second, third, fourth = words.tissues["liver"].curves
    assert not warnings
    assert (first.mode, first.places) == ("tension", (0.1, 0.3))
    assert (first.low, first.high) == ((1e3, 3e3), (2e3, 8e3))
    assert (first.source, first.is_verified) == ("A", True)
    assert (second.places, second.low, second.is_verified) == ((0.2,), (2e3,), False)
    assert third.name == "stress in equibiaxial tension"
    assert (fourth.name, fourth.mode, fourth.places) == ("relaxation", "", (1.0, 60.0))
    assert fourth.low == pytest.approx((0.7, 0.5), rel=1e-12)


def test_limits_of_a_curve_run_straight_between_places_and_end_with_them():
    words, _ = read(f"tissue liver {{ {CURVES} }}")
    curve = words.tissues["liver"].curves[0]
    for place in (0.1, 0.15, 0.2, 0.3):
        low, high = (
            np.interp(place, curve.places, limits) for limits in (curve.low, curve.high)
        )
        assert curve.limits_at(place) == pytest.approx((low, high), rel=1e-12)
    assert curve.limits_at(0.0999) is None and curve.limits_at(0.3001) is None


def test_a_child_inherits_curves_it_has_none_of_its_own_for():
    words, _ = read(
        f"tissue liver {{ {CURVES} }}",
        "tissue scar like liver { known stress in tension at 10 % from 9 kPa to 10 kPa "
        'by "D" }',
    )
    assert [(one.name, one.source) for one in words.tissues["scar"].curves] == [
        ("stress in tension", "D"),
        ("stress in equibiaxial tension", "A"),
        ("relaxation", "C"),
    ]
    assert len(words.tissues["liver"].curves) == 4


@pytest.mark.parametrize(
    ("mode", "told"),
    [("tension", []), ("tension along fibres", []), ("tension across fibres", [])],
)
def test_tension_of_a_tissue_with_fibres_can_be_along_or_across_them(mode, told):
    known = f'known stress in {mode} at 10 % from 9 kPa to 10 kPa by "D"'
    assert (
        codes(f"tissue t {{ Young's modulus = 1 kPa; fibre modulus = 5 kPa; {known} }}") == told
    )


def test_explain_names_curves_and_their_sources():
    words, _ = read(f"tissue liver {{ {CURVES} }}")
    liver = words.tissues["liver"]
    rows = [(row.name, row.value, row.how) for row in tissue_rows(liver) if row.kind == "known"]
    assert rows == [
        ("known stress in tension", "1 kPa to 2 kPa at 10 % … 3 kPa to 8 kPa at 30 %", "A"),
        ("known stress in tension", "2 kPa to 4 kPa at 20 %", "B (unverified)"),
        ("known stress in equibiaxial tension", "2 kPa to 4 kPa at 10 %", "A"),
        ("known relaxation", "0.7 to 0.8 at 1 s … 0.5 to 0.6 at 60 s", "C"),
    ]
    plain = as_dict(words, [liver])["tissues"]["liver"]["curves"]
    assert plain[0] == {
        "of": "stress in tension",
        "places": [0.1, 0.3],
        "low": [1e3, 3e3],
        "high": [2e3, 8e3],
        "source": "A",
        "verified": True,
        "place": "t.tis:4",
    }
