"""Unstable equilibria are told from stable ones, by Euler's load of a chain and in runs."""

import itertools

import numpy as np
import pytest

import tissuec
from tests.hand_net import make_net, start
from tissuec.engine.execution import event_handler
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.rest import LOOSE, rests_pressed
from tissuec.mechanics.rigid import NeutralMotions
from tissuec.mechanics.stability import is_firm, softest, unstable_node

COLUMN = """language 1
tissue gum { spring constant = 100 N/m; viscosity = 0.5 N*s/m; mass = 1 g }
body column { mesh is explicit; tissue is gum }
table nodes of column in mm with columns "id x" { 1 0; 2 10; 3 20; 4 30 }
table springs of column with columns "a b" { 1 2; 2 3; 3 4 }
set low = nodes of column in [1]
set high = nodes of column in [4]
environment { gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m }
script {
  at 0 s: fix low
  from 0 s to 0.3 s: move high by (SHIFT, 0, 0) mm using smooth profile
}
simulate { duration = 0.6 s; tolerance = 1e-3 }
output { trajectory every 0.2 s }
"""


def pressed(stiffening, load):
    """Return a straight chain, held at one end and pressed by a load at the other.

    Springs of ``stiffening`` [N/m] that pull sideways at its middle node keep it straight.
    """
    position = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 1, 0], [1, -1, 0], [1, 0, 1], [1, 0, -1]]
    ends = [[0, 1], [1, 2], [1, 3], [1, 4], [1, 5], [1, 6]]
    rest = [1 + load / 100, 1 + load / 100, 1, 1, 1, 1]
    stiffness = [100.0, 100.0, *[stiffening] * 4]
    net = make_net(position, ends, stiffness=stiffness, rest=rest)
    state = start(net)
    state.holders["fix"] = np.array([0, 2, 3, 4, 5, 6])
    return state


@pytest.mark.parametrize(("part", "is_stable"), [(0.99, True), (1.01, False)])
def test_a_braced_joint_is_stable_up_to_its_known_load(part, is_stable):
    """The middle moves sideways against 2 k, while a pressure P takes 2 P / L away."""
    stiffening = 3.0
    state = pressed(stiffening, part * stiffening)
    assert rests_pressed(state)
    assert (unstable_node(state) is None) == is_stable


@pytest.mark.parametrize(("part", "is_stable"), [(0.9, True), (1.1, False)])
def test_a_frame_that_nothing_holds_is_firm_up_to_the_same_load(part, is_stable):
    """As above, in a frame that carries the pressure, and can move and turn as a whole."""
    held = pressed(3.0, part * 3.0)
    position = held.position[:7]
    ends = held.springs.ends.tolist()
    rest, stiffness = held.springs.rest.tolist(), held.springs.stiffness.tolist()
    for a, b in itertools.combinations((0, 2, 3, 4, 5, 6), 2):
        ends.append([a, b])
        # The bar between the pressed ends is drawn by the load.
        drawn = part * 3.0 / 1e4 if (a, b) == (0, 2) else 0.0
        rest.append(float(np.linalg.norm(position[a] - position[b])) - drawn)
        stiffness.append(1e4)
    state = start(make_net(position, ends, stiffness=stiffness, rest=rest))
    balance = Balance(state, np.ones(7, dtype=bool))
    assert np.abs(balance.force(balance.bars(position))).max() < 1e-12
    assert NeutralMotions.of(balance, position).count == 6
    assert is_firm(balance, position) == is_stable
    (mode,) = softest(balance, position)
    assert (mode.resists > LOOSE) == is_stable


def test_a_net_without_pressure_or_in_motion_does_not_rest_under_pressure():
    assert not rests_pressed(pressed(3.0, -1.0))
    moving = pressed(3.0, 4.0)
    moving.velocity[1] = 1.0
    assert not rests_pressed(moving)


def test_a_run_notes_that_a_straight_column_rests_under_pressure():
    run = tissuec.run(COLUMN.replace("SHIFT", "-6"))
    notes = [event for event in run.events if event.kind == "note"]
    assert [round(note.time, 9) for note in notes] == [0.3]
    assert "unstable equilibrium" in notes[0].cause
    assert "node 2 of column" in notes[0].cause or "node 3 of column" in notes[0].cause


def test_only_the_run_is_looked_at_and_not_its_companion(monkeypatch):
    looked, look = [], event_handler.rests_pressed
    monkeypatch.setattr(
        event_handler, "rests_pressed", lambda state: looked.append(state.time) or look(state)
    )
    run = tissuec.run(COLUMN.replace("SHIFT", "3"), companion="inline")
    assert run.promise.state == "kept"
    assert looked == sorted(set(looked)) != []


def test_a_run_that_draws_the_column_notes_nothing():
    run = tissuec.run(COLUMN.replace("SHIFT", "3"))
    assert not [event for event in run.events if event.kind == "note"]


def test_check_tells_a_column_drawn_under_pressure():
    drawn = COLUMN.replace("mass = 1 g", "mass = 1 g; prestress = -10 %").replace("SHIFT", "0")
    drawn = drawn.replace(
        "from 0 s to 0.3 s: move high by (0, 0, 0) mm using smooth profile", ""
    )
    drawn = drawn.replace("fix low", "fix low\n  at 0 s: fix high")
    assert "W307" in {finding.code for finding in tissuec.check(drawn)}
    settled = drawn.replace("fix high", "fix high\n  at 0 s: settle")
    assert "W307" not in {finding.code for finding in tissuec.check(settled)}
