"""Every law of a solid: at rest it is that of its shear modulus, and the reference agrees."""

import numpy as np
import pytest

from tissuec.forces import solid_strain
from tissuec.laws.solid import SOLID_LAWS
from tissuec.validate.forces.elements import slopes_of

SAMPLES = {
    "neo hookean": {},
    "mooney rivlin": {"share": 0.3},
    "yeoh": {"second": 0.6, "third": 1.8},
    "exponential": {"stiffening": 0.4},
    "veronda westmann": {"stiffening": 0.3},
}
FIRST, SECOND = np.array([3.0, 3.05, 3.4, 4.1]), np.array([3.0, 3.04, 3.5, 4.3])


def test_every_law_has_a_sample():
    assert set(SAMPLES) == set(SOLID_LAWS)


@pytest.mark.parametrize("name", SAMPLES)
def test_at_rest_a_law_has_its_shear_modulus(name):
    law, rest = SOLID_LAWS[name](**SAMPLES[name]), {"i1": 3.0, "i2": 3.0}
    assert law.energy().at(rest) == pytest.approx(0.0, abs=1e-15)
    # Near rest, I1 and I2 grow alike, so that both count for the shear modulus.
    slopes = solid_strain.by_first(law).at(rest) + solid_strain.by_second(law).at(rest)
    assert slopes == pytest.approx(0.5, rel=1e-14)


@pytest.mark.parametrize("name", SAMPLES)
def test_the_reference_has_the_same_slopes(name):
    law = SOLID_LAWS[name](**SAMPLES[name])
    values = {"i1": FIRST, "i2": SECOND}
    own = slopes_of(law)(FIRST, SECOND)
    for mine, theirs in zip((solid_strain.by_first, solid_strain.by_second), own, strict=True):
        np.testing.assert_allclose(mine(law).at(values) + 0.0 * FIRST, theirs, rtol=1e-12)
