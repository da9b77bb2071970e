"""Blocks of elements that relax or yield as text, and what walls and blocks are checked for."""

import re

import numpy as np
import pytest

from tests.engine.running import Bench
from tests.validate.scenes import compiled_scene, quantity, validated
from tests.whole_runs import carried_out, open_balance

SCENE = """language 1
tissue gel {{
  Young's modulus = 10 kPa; Poisson's ratio = {ratio}; density = 1000 kg/m^3
  {memory}
}}
body block {{
  mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to ({size}) mm }}
  tissue is gel
  {body}
}}
set low = nodes of block where z < 0.1 mm
set high = nodes of block where z > {top}
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ {script} }}
simulate {{ duration = {duration}; {method} }}
output {{ trajectory every 5 ms; energy every 5 ms; force of high every 5 ms
          stress of high every 5 ms }}
"""
SHARES = (0.5, 0.2, 0.1)
TIMES = (0.005, 0.02, 0.1)
PRONY = """relaxing share = 50 %; relaxation time = 5 ms
  second relaxing share = 20 %; second relaxation time = 20 ms
  third relaxing share = 10 %; third relaxation time = 0.1 s"""
ONE = "relaxing share = 60 %; relaxation time = 20 ms; retardation time = 1 ms"
PULLED = """at 0 s: fix low
  from 0 s to 20 ms: move high by (3, 0, 2) mm using smooth profile
  from 40 ms to 60 ms: move high by (-3, 0, -2) mm using smooth profile"""
SETTLED = """at 0 s: fix low
  from 0 s to 20 ms: move high by (2, 0, 1) mm using smooth profile
  at 30 ms: settle"""


def scene(
    memory=PRONY, *, ratio=0.3, size="5, 5, 5", top="4.9 mm", body="", script="at 0 s: fix low",
    duration="0.1 s", method="tolerance = 1e-8",
):  # fmt: skip
    return SCENE.format(
        memory=memory, ratio=ratio, size=size, top=top, body=body, script=script,
        duration=duration, method=method,
    )  # fmt: skip


#: By how much scenes are hastened for the reference, which takes long; slowly with -m slow.
HASTES = (8.0, pytest.param(1.0, marks=pytest.mark.slow))


def hastened(text, factor):
    """Return a scene whose script, duration and output take a part of their time."""
    before, script, after = text.partition("script {")
    faster = re.sub(r"([\d.]+) (m?s)\b", lambda t: f"{float(t[1]) / factor:g} {t[2]}", after)
    return before + script + faster


def stepped(network, method, count, end=0.02):
    """Return where bodies are after equal steps, in sides of an element of 5 mm."""
    found = Bench(network, end, method=method, step=end / count, times=[end]).run()
    assert found.end.kind == "reached"
    return found.position[0] / 5e-3


def observed_order(network, method, counts):
    """Return the order at which a method comes closer to what small steps find."""
    exact = stepped(network, "dop853", 400)
    errors = [np.abs(stepped(network, method, count) - exact).max() for count in counts]
    return -np.polyfit(np.log(counts), np.log(errors), 1)[0]


def the_reference_agrees(text, *, position, balance, force):
    """Check a scene against the reference.

    Args:
        position, balance, force: Errors that are allowed, of the last that of ``high``.
    """
    found = validated(text)
    assert found.verdict == "kept"
    assert quantity(found, "position").error < position
    assert quantity(found, "energy balance").error < balance
    assert quantity(found, "force of high").error < force


def relaxed(time, rate, end, modulus):
    """Return the stress of a strain that grows evenly until an end, and is held then [Pa].

    Args:
        modulus: That of the stress in the end [Pa]; shares are those of ``PRONY``.
    """
    drawn = np.minimum(time, end)
    found = modulus * rate * drawn
    for share, tau in zip(SHARES, TIMES, strict=True):
        after = np.exp(-(time - drawn) / tau)
        found = found + modulus * share / 0.2 * rate * tau * -np.expm1(-drawn / tau) * after
    return found


def relaxes_when_held(text, *, area, along, shear, close):
    """Check force and stress of a body that is sheared by 0.1 % in 10 ms, and held.

    Args:
        area: Of its section [m²].
        along, shear: Columns of the force and of the stress.
        close: Relative difference that is allowed.
    """
    _, recording = carried_out(compiled_scene(text))
    time, force = recording.log_arrays("force of high")
    stress = recording.log_arrays("stress of high")[1]
    expected = relaxed(time, 0.1, 0.01, 10e3 / 2.6)
    np.testing.assert_allclose(force[:, along], area * expected, rtol=close, atol=1e-12)
    np.testing.assert_allclose(stress[:, shear], expected, rtol=close, atol=1e-6)
    assert np.abs(open_balance(recording)).max() < 1e-9
    lost = recording.energy_arrays()[1][:, 4]
    assert (np.diff(lost) > 0.0).all()


def branches_gave_way(outcome, recording, kind, *, since, still):
    """Check that settling left elements without branches, which do not move.

    Args:
        since: When they settled [s].
        still: Motions that are allowed [m].
    """
    (made,) = outcome.state.of_kind(kind)
    at_rest = outcome.state.position
    bare = made.relaxed.energy(0.0, at_rest)
    assert made.recalling(outcome.state.velocity).energy(0.0, at_rest) == pytest.approx(
        bare, rel=1e-9
    )
    frames = recording.frame_arrays()
    later = frames[1][frames[0] > since]
    assert np.abs(later - later[0]).max() < still
