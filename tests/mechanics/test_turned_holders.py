"""Nets between holders that turn far begin near their equilibrium."""

import numpy as np
import pytest

import tissuec
from tests.every import every
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.mechanics import newton
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.settling import settle
from tissuec.mechanics.turned_holders import after_turns

BAR = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }}
body bar {{
  mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to (60, 10, 10) mm }}; tissue is gel
}}
set near = nodes of bar where x < 0.01 mm
set far = nodes of bar where x > 59.99 mm
environment {{ gravity = (0, 0, 0) m/s^2{more} }}
script {{ at 0 s: {{ fix near; hold far }} }}
simulate {{ duration = 1 s; integrator is equilibrium; step = 1 s }}
output {{ force(near) every 1 s }}
"""
CENTRE = np.array([0.0, 5e-3, 5e-3])


def turned_bar(angle, more=""):
    """Return a bar whose far end is turned about its axis [rad], and places before that."""
    state = state_at_start(tissuec.compile(BAR.format(more=more)))
    state.place_held()
    before = state.position.copy()
    far = np.isclose(before[:, 0], 60e-3)
    state.position[far] = turned(before[far], angle)
    return state, before


def turned(places, angle):
    """Return places that are turned about the axis of the bar by angles [rad]."""
    _, y, z = (places - CENTRE).T
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.stack([places[:, 0], cosine * y - sine * z, sine * y + cosine * z], 1) + CENTRE


@every("degrees", [30.0, 90.0, 150.0])
def test_a_bar_is_twisted_evenly(degrees):
    state, before = turned_bar(np.deg2rad(degrees))
    balance = Balance(state, ~state.held)
    found = after_turns(balance, before, state.position)
    drawn = before[balance.free]
    even = turned(drawn, np.deg2rad(degrees) * drawn[:, 0] / 60e-3)
    # Edges along the bar do not turn as sections do: they draw these together a little.
    assert np.abs(found - even).max() < 0.05 * 5e-3 * np.deg2rad(degrees) ** 2


def test_holders_that_turn_little_or_deform_or_slide_foretell_nothing():
    state, before = turned_bar(0.1)
    assert after_turns(Balance(state, ~state.held), before, state.position) is None
    state, before = turned_bar(1.0)
    far = np.isclose(before[:, 0], 60e-3)
    state.position[far, 1] *= 1.1
    assert after_turns(Balance(state, ~state.held), before, state.position) is None
    plane = "\n  symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)"
    state, before = turned_bar(1.0, plane)
    assert after_turns(Balance(state, ~state.held), before, state.position) is None


def test_few_steps_lead_from_there_to_the_equilibrium(monkeypatch):
    steps = []
    given = newton.downhill

    def counted(*asked, **more):
        steps.append(1)
        return given(*asked, **more)

    monkeypatch.setattr(newton, "downhill", counted)
    at_once, before = turned_bar(0.5 * np.pi)
    settle(at_once, np.ones(len(before), dtype=bool))
    assert len(steps) <= 4  # 13 from where tangents lead
    by_parts, _ = turned_bar(0.0)
    far = np.isclose(before[:, 0], 60e-3)
    for part in range(1, 6):
        guess = by_parts.position.copy()
        by_parts.position[far] = turned(before[far], part * 0.1 * np.pi)
        settle(by_parts, np.ones(len(before), dtype=bool), guess)
    assert at_once.position == pytest.approx(by_parts.position, abs=1e-9)
