"""Stability of laws of solids, against differences of their energies."""

import numpy as np
import pytest

from tests.laws.test_solid_laws import KEEPING, SAMPLES
from tissuec.laws.solid import SOLID_LAWS
from tissuec.laws.solid.invariants import Yeoh
from tissuec.laws.stability import is_stable, stable_strains

STEP = 1e-4


def stored(law, one, two):
    """Return the energy of a solid by two of its logarithmic principal strains."""
    squares = np.exp(2.0 * np.array([one, two, -one - two]))
    return law.energy().at(
        {"i1": squares.sum(), "i2": (1.0 / squares).sum(), "trace": squares.sum()}
    )


def least(law, one, two):
    """Return the least eigenvalue of the second differences of the energy."""
    h = STEP
    matrix = np.empty((2, 2))
    for k, m in np.ndindex(2, 2):
        p, q = np.eye(2)[k] * h, np.eye(2)[m] * h
        at = [stored(law, *(np.array([one, two]) + s * p + t * q))
              for s, t in ((1, 1), (1, -1), (-1, 1), (-1, -1))]  # fmt: skip
        matrix[k, m] = (at[0] - at[1] - at[2] + at[3]) / (4.0 * h * h)
    return np.linalg.eigvalsh(matrix)[0]


@pytest.mark.parametrize(
    "law",
    [
        *(SOLID_LAWS[name](**KEEPING[name]) for name in KEEPING),
        Yeoh(second=-0.3),
        SOLID_LAWS["veronda westmann"](stiffening=0.05),
    ],
    ids=repr,
)
def test_a_law_is_stable_where_second_differences_are_positive(law):
    rng = np.random.default_rng(4)
    for one, two in rng.uniform(-0.6, 0.6, size=(60, 2)):
        x = np.exp(2.0 * np.array([one, two, -one - two]))
        value = least(law, one, two)
        if abs(value) > 1e-4:  # rounding of differences: 1e-16 / STEP²
            assert is_stable(law, x.sum(), (1.0 / x).sum()) == (value > 0.0)


def test_usual_laws_are_stable():
    laws = {name: SOLID_LAWS[name](**KEEPING[name]) for name in KEEPING}
    # The share -1/2 of I2 is what only steep exponentials outweigh.
    unstable = {name for name, law in laws.items() if stable_strains(law)}
    assert unstable == {"veronda westmann"}
    assert stable_strains(SOLID_LAWS["veronda westmann"](stiffening=3.0)) is None


def test_limits_are_where_second_differences_vanish():
    law = Yeoh(second=-0.3)
    found = stable_strains(law)
    along = np.log(1.0 + found.tension)
    for way in (
        along * np.array([1.0, -0.5]),
        np.log(1.0 - found.compression) * np.array([1.0, -0.5]),
        np.log(1.0 + found.shear) * np.array([1.0, -1.0]),
    ):
        assert least(law, *(0.98 * way)) > 0.0 > least(law, *(1.02 * way))
    # A third number that is large enough keeps the law stable.
    assert stable_strains(Yeoh(second=-0.3, third=1.0)) is None


# --- laws of shape and volume together --------------------------------------------------------


def test_saint_venant_kirchhoff_in_tension_and_compression_has_a_closed_form():
    """Without lateral strain, τ = E/2 (λ⁴ - λ²), which falls below λ² = 1/2 as λ falls."""
    found = stable_strains(SOLID_LAWS["saint venant kirchhoff"](), lame=0.0)
    assert (found.tension, found.shear) == (None, None)
    step = np.log(2.0) / 400.0  # of the strains that are tried
    assert found.compression == pytest.approx(1.0 - 0.5**0.5, abs=step)


def whole(law, strains, lame):
    """Return the energy of a whole law by its logarithmic principal strains."""
    square, j = np.exp(2.0 * np.asarray(strains)), np.exp(np.sum(strains))
    trace, cofactors = square.sum(), (j**2 / square).sum()
    g = j ** (-2.0 / 3.0)
    return law.energy().at({
        "i1": g * trace, "i2": g * g * cofactors, "trace": trace, "cofactors": cofactors,
        "j": j, "lame": lame,
    })  # fmt: skip


@pytest.mark.parametrize("name", sorted(set(SAMPLES) - set(KEEPING)))
def test_a_whole_law_is_stable_where_second_differences_are_positive(name):
    law, rng, h, seen = SOLID_LAWS[name](**SAMPLES[name]), np.random.default_rng(4), STEP, set()
    for strains in rng.uniform(-0.6, 0.6, size=(40, 3)):
        matrix = np.empty((3, 3))
        for k, m in np.ndindex(3, 3):
            p, q = np.eye(3)[k] * h, np.eye(3)[m] * h
            at = [whole(law, strains + s * p + t * q, 3.0)
                  for s, t in ((1, 1), (1, -1), (-1, 1), (-1, -1))]  # fmt: skip
            matrix[k, m] = (at[0] - at[1] - at[2] + at[3]) / (4.0 * h * h)
        value, j = np.linalg.eigvalsh(matrix)[0], np.exp(strains.sum())
        x = np.exp(2.0 * strains) * j ** (-2.0 / 3.0)
        if abs(value) > 1e-4:
            found = is_stable(law, x.sum(), (1.0 / x).sum(), j, 3.0)
            assert found == (value > 0.0)
            seen.add(bool(found))
    assert True in seen
