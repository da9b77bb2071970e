"""Tolerances are kept where laws of contact change their formula within a step."""

import pytest

from tests.validate.scenes import quantity, validated


@pytest.mark.parametrize(
    ("scene", "tolerance"),
    [
        # Fine ones, at which errors of contacts show; nodes leave a rod faster than damping
        # lets go of them, ...
        pytest.param("edge", "1e-8", marks=pytest.mark.slow),
        # ... and slip on faces whose pressure sinks.
        ("contact", "1e-5"),
        pytest.param("contact", "1e-6", marks=pytest.mark.slow),
        pytest.param("edge", "1e-7", marks=pytest.mark.slow),
        pytest.param("contact", "1e-7", marks=pytest.mark.slow),
        pytest.param("contact", "1e-8", marks=pytest.mark.slow),
    ],
)
def test_tolerances_are_kept_where_formulas_of_contact_change(scene, tolerance, repository):
    text = (repository / f"tests/validate/mutated/{scene}.tis").read_text(encoding="utf-8")
    found = validated(text.replace("tolerance = 1e-7", f"tolerance = {tolerance}"))
    assert found.verdict == "kept", found.reasons
    # Not by luck: with corners unseen, errors were anything from 0.5 to 17 tolerances.
    assert quantity(found, "position").error < 0.2 * float(tolerance)
