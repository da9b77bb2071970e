"""Tests of a tissue in motion: free oscillation, and ramp and hold.

A bar is twisted at its free end and let go, so that it is shear alone that is braked: a mode of
the angular frequency ω falls by exp(-ω² τ t / 2), τ being the retardation time. A strip, which
does not resist being twisted, is drawn: only its change of shape is braked, so that its mode
falls by 2/3 (1 + ν) of that. (R. W. Clough, J. Penzien, Dynamics of Structures, 2003, on
damping in proportion to stiffness.)
"""

from math import pi, sqrt
from typing import NamedTuple

import numpy as np

from tissuec.analysis.lab.bench import TestBench, Unmeasured
from tissuec.analysis.lab.coupon import Coupon
from tissuec.analysis.lab.statics import TensionTest
from tissuec.model.inelastic import TIMES
from tissuec.model.network import Floats
from tissuec.scene.tissues.quantities import RETARDATION_TIME, YOUNGS_MODULUS

SMALL = 1e-3  # strain
DAMPING = 0.1  # of what is critical: coupons are as long as gives it
_PERIODS = 3.0
_SAMPLES = 180
_RAMP = 0.1  # of the shortest relaxation time


class Oscillation(NamedTuple):
    """Free oscillation of a coupon.

    Attributes:
        time: Retardation time [s].
        frequency: Of the undamped mode [Hz].
    """

    time: float
    frequency: float


def width_for(bench: TestBench, tension: TensionTest) -> float:
    """Return how wide a coupon is that oscillates with some damping [m]."""
    tau = _expected_time(bench)
    if not tau > 0.0:
        return 0.02
    # Twice as long as wide: ω = π c / 2 L and ω τ / 2 = DAMPING, at about the speed of shear.
    speed = sqrt(tension.modulus / 3.0 / tension.density)
    return pi * speed * tau / (8.0 * DAMPING)


def _expected_time(bench: TestBench) -> float:
    """Return about which retardation time there is [s], to choose sizes and times by."""
    given = {key: one.value for key, one in bench.tissue.given.items()}
    if RETARDATION_TIME in given:
        return given[RETARDATION_TIME]
    if "shear viscosity" in given and YOUNGS_MODULUS in given:
        return 3.0 * given["shear viscosity"] / given[YOUNGS_MODULUS]
    if given.get("spring constant"):
        return given.get("viscosity", 0.0) / given["spring constant"]
    return 0.0


def oscillation(bench: TestBench, coupon: Coupon, tension: TensionTest) -> Oscillation:
    """Return the free oscillation of a coupon that is stretched or twisted and released.

    Raises:
        Unmeasured: The run stopped, or the coupon does not come to rest.
    """
    tau = _expected_time(bench)
    slowness = 1.0 if coupon.thickness is not None else 3.0 / 0.84
    period = 4.0 * coupon.length * sqrt(tension.density / tension.modulus * slowness)
    is_slow = pi * tau > period  # beyond critical damping
    duration = 5.0 * tau if is_slow else _PERIODS * period
    script, sets, watched, axis = _let_go(coupon, tension.modulus)
    reading = bench.run(
        coupon,
        ["at 0 s: fix lab x0", *(f"at 0 s: {order}" for order in script)],
        ("x0", "x1"),
        [watched],
        f"duration = {duration:.15g} s; integrator is automatic",
        interval=f"{duration / _SAMPLES:.15g} s",
        more=sets,
    )
    if reading.stopped:
        raise Unmeasured(reading.stopped)
    place = reading.logs[watched][:, axis]
    begins = reading.time > (0.0 if is_slow else 0.5 * period)  # higher modes are gone then
    found = _fitted(reading.time[begins], place[begins], 2.0 * pi / period, tau)
    if is_slow and not found.time > 0.0:
        raise Unmeasured("it does not come to rest")
    if coupon.thickness is None:
        return found
    return found._replace(time=1.5 * found.time / (1.0 + tension.ratio))


def let_go(bench: TestBench, coupon: Coupon, tension: TensionTest) -> dict[str, float]:
    """Return the retardation time [s] and the shear viscosity [Pa s] of a coupon, by quantity.

    Raises:
        Unmeasured: The run stopped, or the coupon does not come to rest.
    """
    found = oscillation(bench, coupon, tension)
    shear = tension.modulus / (2.0 * (1.0 + tension.ratio))
    return {"retardation time": found.time, "shear viscosity": found.time * shear}


def _let_go(coupon: Coupon, modulus: float) -> tuple[list[str], list[str], str, int]:
    """Return orders, sets, what is logged, and which of its columns counts."""
    if coupon.thickness is not None:
        orders = [*coupon.pushes("x1", (SMALL * modulus, 0.0, 0.0)), "settle"]
        return [*orders, *coupon.releases("x1")], [], "position of lab x1", 0
    force = SMALL * modulus * coupon.section / 16.0
    corners = {"a": (1, 1), "b": (0, 1), "c": (0, 0), "d": (1, 0)}
    sets = [f"set lab corner {name} = {coupon.corner(*ends)}" for name, ends in corners.items()]
    forces = {
        name: ((1 - 2 * z) * force, (2 * y - 1) * force) for name, (y, z) in corners.items()
    }
    orders = [
        f"push lab corner {name} with (0, {along_y:.15g}, {along_z:.15g}) N"
        for name, (along_y, along_z) in forces.items()
    ]
    orders += ["settle", *(f"stop pushing lab corner {name}" for name in corners)]
    return orders, sets, "position of lab corner a", 2


def _fitted(time: Floats, place: Floats, frequency: float, tau: float) -> Oscillation:
    """Return the oscillator x'' + ω² τ x' + ω² x = 0 that moves like this about some place.

    Args:
        time: [s], shape (moment,).
        place: [m], shape (moment,).
        frequency: About the angular frequency ω [rad/s].
        tau: About τ [s].
    """
    from scipy.optimize import least_squares

    place = place - place[-1]
    place = place / np.abs(place).max()

    def rest(guess: Floats) -> Floats:
        omega, braking = np.exp(guess[0]), guess[1]
        root = np.sqrt(complex(braking**2 - 1.0))
        ways = [np.exp(omega * (-braking + sign * root) * time) for sign in (1.0, -1.0)]
        basis = [ways[0].real, ways[0].imag] if root.imag else [way.real for way in ways]
        columns = np.stack([*basis, np.ones_like(time)], axis=1)
        return columns @ np.linalg.lstsq(columns, place, rcond=None)[0] - place

    start = np.array([np.log(frequency), 0.5 * frequency * tau])
    found = least_squares(rest, start, x_scale=(0.1, 0.1), xtol=1e-10)
    omega, braking = float(np.exp(found.x[0])), float(found.x[1])
    return Oscillation(2.0 * braking / omega, omega / (2.0 * pi))


def _times(bench: TestBench) -> list[float]:
    return [bench.tissue.given[key].value for key in TIMES if key in bench.tissue.given]


class HoldTest(NamedTuple):
    """Relaxation of the force on a coupon that is held.

    Attributes:
        share: Of the largest force, what is lost in the end.
        time: After the ramp, in which all but 1/e of that is lost [s].
    """

    share: float
    time: float


def width_to_hold(bench: TestBench, tension: TensionTest) -> float:
    """Return how wide a coupon is in which waves run much faster than the ramp lasts [m]."""
    return sqrt(tension.modulus / tension.density) * _RAMP * min(_times(bench)) / 16.0


def held(bench: TestBench, coupon: Coupon, tension: TensionTest) -> HoldTest:
    """Return the relaxation of the force on a coupon that is stretched by 1 % and held.

    Raises:
        Unmeasured: The run stopped.
    """
    crossing = coupon.length * sqrt(tension.density / tension.modulus)
    times = _times(bench)
    ramp, end = max(_RAMP * min(times), 8.0 * crossing), 5.0 * max(times)
    draw = f"move lab x1 by ({0.01 * coupon.length:.15g}, 0, 0) m using smooth profile"
    reading = bench.run(
        coupon,
        ["at 0 s: fix lab x0", f"from 0 s to {ramp:.15g} s: {draw}"],
        ("x0", "x1"),
        ["force of lab x1"],
        f"duration = {ramp + end:.15g} s; integrator is automatic",
        interval=f"{ramp / 10.0:.15g} s",
    )
    if reading.stopped:
        raise Unmeasured(reading.stopped)
    force = reading.logs["force of lab x1"][:, 0]
    start = int(np.searchsorted(reading.time, ramp))
    left = force[start:] - force[-1]
    later = start + int(np.argmax(left <= np.exp(-1.0) * left[0]))
    share = 1.0 - float(force[-1] / force.max())
    return HoldTest(share, float(reading.time[later] - reading.time[start]))
