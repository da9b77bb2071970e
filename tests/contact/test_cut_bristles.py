"""Bristles of faces at the ends of steps, one by one: their lengths, and which of them slip."""

from types import SimpleNamespace

import numpy as np
import pytest

from tissuec.forces.contact.bristle_kernel import AHEAD, OVER, SLIDES, SLIPS, cut_bristles

RATE, SLIP = 100.0, 0.02  # [1/s], [m]
WAY = np.array([0.6, 0.0, 0.8])
BESIDE = np.array([0.8, 0.0, -0.6])


def cut(length, growth, slid, turn=0.0, rounded=None):
    """Cut a bristle along ``WAY``; return its length vector [m], its rate, whether it slips.

    Args:
        length: Before [m].
        growth: Rate along itself [m/s].
        slid: Whether it slipped in the step, 0 or 1.
        turn: Rate across itself [m/s].
        rounded: What is left of the rate along itself where it slips [m/s].
    """
    bent = np.zeros((1, AHEAD + 1))
    bent[0, SLIPS], bent[0, SLIDES], bent[0, AHEAD] = SLIP, slid, growth
    v, a = np.zeros(6), np.zeros(6)
    v[3:] = RATE * length * WAY
    along = growth if rounded is None else rounded
    a[3:] = RATE * (along * WAY + turn * BESIDE)
    cut_bristles(v, a, SimpleNamespace(bent=bent, memory=np.array([1]), rate=RATE))
    assert not v[:3].any() and not a[:3].any()
    return v[3:] / RATE, a[3:] / RATE, bent[0, SLIDES]


def test_a_bristle_that_is_too_long_is_cut_and_grows_no_more():
    bristle, rate, slips = cut(0.03, 0.5, 0.0, turn=0.2)
    assert slips == 1.0
    assert bristle == pytest.approx(OVER * SLIP * WAY, rel=1e-12)
    assert rate == pytest.approx(0.2 * BESIDE, abs=1e-15)


def test_a_bristle_that_is_too_long_and_shrinks_keeps_its_rate():
    # The pressure has fallen, so that it slips, although the surface moves back.
    bristle, rate, slips = cut(0.03, -0.5, 0.0)
    assert slips == 1.0 and np.linalg.norm(bristle) == pytest.approx(SLIP, rel=1e-8)
    assert rate == pytest.approx(-0.5 * WAY, rel=1e-12)


@pytest.mark.parametrize("growth", [0.5, 0.0])
def test_what_slips_follows_the_limit_where_pressure_rises(growth):
    bristle, rate, slips = cut(0.015, growth, 1.0, turn=0.2)
    assert slips == 1.0
    assert bristle == pytest.approx(OVER * SLIP * WAY, rel=1e-12)
    assert rate == pytest.approx(0.2 * BESIDE, abs=1e-15)


@pytest.mark.parametrize("rounded", [-1e-17, 1e-17])
def test_rounding_of_a_rate_that_is_cut_is_no_turning_back(rounded):
    bristle, rate, slips = cut(0.015, 0.5, 1.0, rounded=rounded)
    assert slips == 1.0
    assert bristle == pytest.approx(OVER * SLIP * WAY, rel=1e-12)
    assert np.abs(rate).max() < 1e-16


@pytest.mark.parametrize(("growth", "slid"), [(-0.5, 1.0), (-1e-6, 1.0), (0.5, 0.0)])
def test_what_turns_back_or_sticks_is_left_alone(growth, slid):
    bristle, rate, slips = cut(0.015, growth, slid)
    assert slips == 0.0
    assert bristle == pytest.approx(0.015 * WAY, rel=1e-12)
    assert rate == pytest.approx(growth * WAY, rel=1e-12)


def test_without_pressure_nothing_is_left_of_a_bristle(monkeypatch):
    monkeypatch.setattr("tests.contact.test_cut_bristles.SLIP", 0.0)
    bristle, rate, slips = cut(0.015, 0.5, 1.0)
    assert slips == 0.0 and not bristle.any()
    assert rate == pytest.approx(0.5 * WAY, rel=1e-12)
