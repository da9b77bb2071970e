"""Scenes as a user writes them against closed forms: 1e-8 of the motion at tolerance 1e-9.

The promise itself is 1e-9; the factor of ten leaves room for closed forms that are themselves
computed with cancellation.
"""

import numpy as np
import pytest

from tissuec.core.source import Source
from tissuec.engine.execution.memory_recorder import MemoryRecording
from tissuec.engine.execution.recorder import Recorder
from tissuec.engine.execution.run import run
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

PROMISED = 1e-8


def simulate(text, integrator="automatic"):
    """Return times, positions, velocities and the outcome of a scene."""
    source = Source("scene.tis", text.replace("INTEGRATOR", f"integrator is {integrator}"))
    compiled, warnings = compile_request(Request(source))
    assert not [w for w in warnings if w.code not in ("W301", "W302")]
    memory = MemoryRecording()
    recorder = Recorder(compiled.network, compiled.plan, memory)
    outcome = run(compiled.network, compiled.plan, recorder)
    assert outcome.kind == "done", outcome.message
    assert not outcome.failures
    time, position, velocity, *_ = memory.frame_arrays()
    return time, position, velocity, outcome


def net(nodes, springs, *, script="", more="", duration=1.0, every=0.01, gravity="(0, 0, 0)"):
    """Return a scene of explicit tables; rows are lists of numbers in SI units."""
    rows = "\n".join(" ".join(repr(float(cell)) for cell in row) for row in nodes)
    bars = "\n".join(
        " ".join([*map(str, row[:2]), *(repr(float(cell)) for cell in row[2:])])
        for row in springs
    )
    table = (
        'table springs of net in m with columns "a b spring constant in N/m viscosity in N*s/m '
        f'rest length breaking force in N" {{\n{bars}\n}}\n'
    )
    return f"""language 1
body net {{ mesh is explicit; rupture is allowed {more} }}
table nodes of net in m with columns "x mass in kg vx in m/s y vy in m/s" {{
{rows}
}}
{table if springs else ""}
environment {{ gravity = {gravity} m/s^2 }}
script {{
{script}
}}
simulate {{ duration = {duration!r} s; INTEGRATOR; tolerance = 1e-9 }}
output {{ trajectory every {every!r} s }}
"""


def node(x, mass, vx=0.0, y=0.0, vy=0.0):
    return [x, mass, vx, y, vy]


def fix(*ids):
    listed = ", ".join(map(str, ids))
    return f"set held = nodes of net in [{listed}]\n", "at 0 s: fix held"


def scene_with_fixed(ids, nodes, springs, *, script="", sets="", **options):
    held, order = fix(*ids)
    text = net(nodes, springs, script=f"{order}\n{script}", **options)
    return text + held + sets


def worst(position, exact, motion):
    return np.abs(position - exact).max() / motion


def damped(t, start, mass, c, d):
    """Return the elongation of mass x'' + d x' + c x = 0 that starts at rest from ``start``."""
    roots = np.roots([mass, d, c]).astype(complex)
    if abs(roots[0] - roots[1]) < 1e-6 * abs(roots[0]):
        rate = -d / (2.0 * mass)
        return start * (1.0 - rate * t) * np.exp(rate * t)
    a, b = roots
    return (start * (b * np.exp(a * t) - a * np.exp(b * t)) / (b - a)).real


@pytest.mark.parametrize("ratio", [0.05, 1.0, 4.0], ids=["under", "critical", "over"])
def test_two_masses_swing_as_the_damped_oscillator(ratio):
    m1, m2, c, rest, stretch = 0.01, 0.03, 50.0, 0.1, 0.02
    reduced = m1 * m2 / (m1 + m2)
    d = ratio * 2.0 * np.sqrt(c * reduced)
    time, x, *_ = simulate(
        net([node(0, m1), node(rest + stretch, m2)], [(1, 2, c, d, rest, 9.0)])
    )
    length = x[:, 1, 0] - x[:, 0, 0]
    assert worst(length, rest + damped(time, stretch, reduced, c, d), stretch) < PROMISED


@pytest.mark.parametrize("mode", [1, 3, 6])
def test_a_fixed_chain_swings_in_its_normal_modes(mode):
    count, mass, c, d, gap, size = 6, 0.02, 80.0, 0.05, 0.05, 0.004
    j = np.arange(count + 2)
    shape = np.sin(j * mode * np.pi / (count + 1))
    nodes = [node(k * gap + size * shape[k], mass) for k in j]
    springs = [(k + 1, k + 2, c, d, gap, 9.0) for k in range(count + 1)]
    time, x, *_ = simulate(scene_with_fixed((1, count + 2), nodes, springs))
    omega = 2.0 * np.sqrt(c / mass) * np.sin(mode * np.pi / (2 * (count + 1)))
    swing = damped(time, size, 1.0, omega**2, d / c * omega**2)
    assert worst(x[:, :, 0], j * gap + np.outer(swing, shape), size) < PROMISED


def test_strong_axial_damping_does_not_brake_a_rigid_rotation():
    mass, c, d, rest, omega = 0.01, 40.0, 5.0, 0.1, 12.0
    length = c * rest / (c - mass / 2 * omega**2)  # tension supplies the centripetal force
    speed = omega * length / 2
    nodes = [node(-length / 2, mass, vy=-speed), node(length / 2, mass, vy=speed)]
    time, x, *_ = simulate(net(nodes, [(1, 2, c, d, rest, 99.0)], duration=2.0))
    exact = length / 2 * np.stack([np.cos(omega * time), np.sin(omega * time)], axis=1)
    assert worst(x[:, 1, :2], exact, length) < PROMISED


def test_a_damped_spring_creeps_under_a_constant_force():
    mass, c, d, rest, force = 1e-3, 30.0, 1.2, 0.1, 0.6
    nodes, springs = [node(0, 1.0), node(rest, mass)], [(1, 2, c, d, rest, 9.0)]
    script = f"at 0 s: push tip with ({force}, 0, 0) N"
    sets = "set tip = nodes of net in [2]\n"
    time, x, *_ = simulate(scene_with_fixed((1,), nodes, springs, script=script, sets=sets))
    exact = rest + force / c - damped(time, force / c, mass, c, d)
    assert worst(x[:, 1, 0], exact, force / c) < PROMISED


def free_end_modes(count, mass, c):
    """Return frequencies and mode shapes of a chain that is fixed at one end."""
    stiffness = c * (
        np.diag([2.0] * (count - 1) + [1.0]) - np.eye(count, k=1) - np.eye(count, k=-1)
    )
    values, shapes = np.linalg.eigh(stiffness / mass)
    return np.sqrt(values), shapes


def free_end_motion(time, start, count, mass, c):
    """Return the displacements of a chain with one free end, released from rest."""
    omega, shapes = free_end_modes(count, mass, c)
    return np.cos(np.outer(time, omega)) * (shapes.T @ start) @ shapes.T


def test_a_hanging_chain_falls_into_the_swing_about_its_stretched_length():
    count, mass, c, gap, g = 5, 0.01, 60.0, 0.1, 9.81
    nodes = [node(k * gap, mass) for k in range(count + 1)]
    springs = [(k + 1, k + 2, c, 0.0, gap, 9.0) for k in range(count)]
    time, x, *_ = simulate(
        scene_with_fixed((1,), nodes, springs, gravity=f"({g}, 0, 0)", duration=0.5)
    )
    below = np.arange(count, 0, -1)  # masses that each spring carries at rest
    sag = np.cumsum(mass * g / c * below)
    length = count * gap + mass * g / c * count * (count + 1) / 2
    assert sag[-1] + count * gap == pytest.approx(length, rel=1e-14)
    exact = gap * np.arange(1, count + 1) + sag + free_end_motion(time, -sag, count, mass, c)
    assert worst(x[:, 1:, 0], exact, sag[-1]) < PROMISED


def test_a_spring_ruptures_at_its_time_and_its_mass_flies_on():
    mass, c, rest, force, strength = 0.02, 50.0, 0.1, 0.4, 0.5
    nodes, springs = [node(0, 1.0), node(rest, mass)], [(1, 2, c, 0.0, rest, strength)]
    script = f"at 0 s: push tip with ({force}, 0, 0) N"
    sets = "set tip = nodes of net in [2]\n"
    time, x, _, outcome = simulate(
        scene_with_fixed((1,), nodes, springs, script=script, sets=sets, duration=0.3)
    )
    omega = np.sqrt(c / mass)
    breaks = np.arccos(1.0 - strength / force) / omega
    ((happened, _),) = [(t, h) for t, h in outcome.logged_events if h.kind == "rupture"]
    assert happened == pytest.approx(breaks, rel=PROMISED)
    swing = force / c * (1.0 - np.cos(omega * time))
    after = time - breaks
    speed = force / c * omega * np.sin(omega * breaks)
    flight = strength / c + speed * after + force / mass * after**2 / 2.0
    exact = rest + np.where(time < breaks, swing, flight)
    assert worst(x[:, 1, 0], exact, np.ptp(exact)) < PROMISED


def test_a_cut_prestressed_chain_draws_back_at_both_ends():
    count, mass, c, gap, part = 4, 0.01, 70.0, 0.05, 0.06
    nodes = [node(k * gap, mass) for k in range(2 * count + 2)]
    springs = [(k + 1, k + 2, c, 0.0, (1 - part) * gap, 9.0) for k in range(2 * count + 1)]
    cut = 0.1
    where = f"({(count + 0.5) * gap}, 0, 0) m"
    script = f"at {cut} s: cut net along plane through {where} facing (1, 0, 0)"
    ends = (1, 2 * count + 2)
    time, x, _, outcome = simulate(
        scene_with_fixed(ends, nodes, springs, script=script, duration=0.6)
    )
    assert [h.springs for _, h in outcome.logged_events if h.kind == "cut"] == [(count,)]
    # At rest about the slack chain, from which each node is drawn by its share.
    drawn = part * gap * np.arange(1, count + 1)
    swing = free_end_motion(np.maximum(time - cut, 0.0), drawn, count, mass, c)
    left = gap * np.arange(1, count + 1) - drawn + swing
    length = gap * (2 * count + 1)
    assert worst(x[:, 1 : count + 1, 0], left, drawn[-1]) < PROMISED
    assert worst(length - x[:, -2 : -count - 2 : -1, 0], left, drawn[-1]) < PROMISED
    at_rest = time < cut
    assert np.abs(x[at_rest, :, 0] - gap * np.arange(2 * count + 2)).max() < 1e-15
