"""Tests of nets of springs at rest: tension and compression, shear, and tension to rupture.

Coupons are under an even stress: it acts on opposite faces, and nothing else holds them. Stress
is force over the area as drawn, strain the change of length over the length as drawn. Curves,
and strains of rupture, begin at rest: prestress makes a coupon shorter than it is drawn.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tissuec.analysis.lab.bench import TICK, TestBench, TestReading, Unmeasured
from tissuec.analysis.lab.coupon import BACK, BODY, FIRST, FRONT, SECOND, Coupon
from tissuec.analysis.lab.rows import StressStrainCurve
from tissuec.core.units import PRESSURE, show
from tissuec.model.network import Floats

SMALL = 1e-4  # strain at which moduli are measured
_WITHIN = 3.0  # how far from it the strain may be
_TRIES = 8
#: Strains to which a curve is drawn, if the tissue does not break before.
FURTHEST, SHORTEST = 0.3, -0.1
LEVELS = 24  # of loads until rupture, on the coarse coupon
_NEAR = np.array(
    [0.1, 0.2, 0.35, 0.5, 0.65, 0.8, *np.linspace(0.9, 1.1, 15)]
)  # times the load of rupture, on others


class TensionTest(NamedTuple):
    """Response of a coupon to a small stress along x.

    Attributes:
        modulus: Stress over strain [Pa].
        ratio: Poisson's, negative strain across over strain along.
        density: Mass over volume [kg/m³].
    """

    modulus: float
    ratio: float
    density: float


# --- small strains ----------------------------------------------------------------------------


def tension(bench: TestBench, coupon: Coupon, guess: float) -> TensionTest:
    """Return the response of a coupon to a small stress.

    Args:
        guess: Of the modulus [Pa]; the load is changed until the strain is small.

    Raises:
        Unmeasured: It does not resist, or no load gives a small strain.
    """
    for _ in range(_TRIES):
        reading = drawn(bench, coupon, [SMALL * guess])
        along, across = strains(reading, coupon)
        strain = float(along[-1] - along[0])
        if strain <= 0.0 or not np.isfinite(strain):
            raise Unmeasured("it has no resistance")
        if SMALL / _WITHIN < strain < SMALL * _WITHIN:
            network, volume = reading.network, coupon.section * coupon.length
            return TensionTest(
                SMALL * guess / strain,
                -float(across[-1] - across[0]) / strain,
                float(network.mass[: network.body_nodes].sum()) / volume,
            )
        guess *= SMALL / strain
    raise Unmeasured("no load was found that gives a small strain")


def shear(bench: TestBench, coupon: Coupon, guess: float) -> float:
    """Return the shear modulus [Pa].

    Twice as much tension along both axes keeps the coupon from rotating under its loads.

    Raises:
        Unmeasured: It does not resist.
    """
    stress = SMALL * guess
    faces = ("x0", "x1", "y0", "y1")
    watched = [f"position of lab {face}" for face in faces]
    levels = [
        _on_both(coupon, (2.0 * stress, 0.0, 0.0), (0.0, 2.0 * stress, 0.0)),
        _on_both(coupon, (0.0, stress, 0.0), (stress, 0.0, 0.0)),
    ]
    reading = bench.rest(coupon, levels, faces, watched)
    _refuse_stopped(reading)
    left, right, low, high = (reading.logs[name][1] - reading.logs[name][0] for name in watched)
    angle = (right - left)[1] / coupon.length + (high - low)[0] / coupon.width
    if not angle > 0.0:
        raise Unmeasured("it has no resistance")
    return float(stress / angle)


def _on_both(coupon: Coupon, *stresses: tuple[float, float, float]) -> list[str]:
    """Return orders for stresses [Pa] on the faces across x, and on those across y."""
    return [
        order
        for axis, stress in zip("xy", stresses, strict=False)
        for end, sign in (("0", -1.0), ("1", 1.0))
        for order in coupon.pushes(f"{axis}{end}", [sign * one for one in stress])
    ]


def drawn(
    bench: TestBench, coupon: Coupon, stresses: Sequence[float], *, rupture: bool = False
) -> TestReading:
    """Return the log without a load and then under stresses, level by level."""
    levels: list[list[str]] = [[]]
    before = 0.0
    for stress in stresses:
        levels.append(_on_both(coupon, (stress - before, 0.0, 0.0)))
        before = stress
    watched = [f"position of {name}" for name in (FIRST, SECOND, FRONT, BACK)]
    watched += [f"ruptured of {BODY}"] if rupture else []
    reading = bench.rest(coupon, levels, ("x0", "x1"), watched, rupture=rupture)
    if not rupture:
        _refuse_stopped(reading)
    return reading


def strains(reading: TestReading, coupon: Coupon) -> tuple[Floats, Floats]:
    """Return strains between the gauges and across, dimensionless, shape (level,) each.

    They are relative to the lengths as drawn.
    """
    first, second, front, back = (
        reading.logs[f"position of {name}"] for name in (FIRST, SECOND, FRONT, BACK)
    )
    along = np.linalg.norm(second - first, axis=1) / (0.5 * coupon.length) - 1.0
    return along, np.linalg.norm(back - front, axis=1) / coupon.width - 1.0


def _refuse_stopped(reading: TestReading) -> None:
    if reading.stopped:
        raise Unmeasured(reading.stopped.partition("; ")[2] or reading.stopped)


# --- large strains ----------------------------------------------------------------------------


class Rupture(NamedTuple):
    """Rupture of a coupon.

    Attributes:
        curve: Until then, or as far as it was drawn.
        strain: Of the gauge just before the first spring broke; NaN if none did.
        stress: [Pa] then.
    """

    curve: StressStrainCurve
    strain: float
    stress: float


def rupture(bench: TestBench, coupon: Coupon, modulus: float, near: float | None) -> Rupture:
    """Return the tension test of a coupon up to rupture.

    Args:
        modulus: Of the tissue [Pa].
        near: Stress at which another coupon broke [Pa]; None if there was none.

    Raises:
        Unmeasured: It has a limit, and breaks at none of the loads, or at the first of them.
    """
    most = np.inf if bench.lacks("breaking force") else _strongest(bench, coupon)
    if not np.isfinite(most):
        stresses = modulus * np.linspace(0.0, FURTHEST, 13)[1:]
        return Rupture(
            _curve(drawn(bench, coupon, stresses.tolist()), coupon, stresses), np.nan, np.nan
        )
    if near is None:
        levels = 1.5 * most * np.linspace(0.0, 1.0, LEVELS + 1)[1:]
        near = _first_break(bench, coupon, levels).stress
    return _first_break(bench, coupon, near * _NEAR)


def _first_break(bench: TestBench, coupon: Coupon, stresses: Floats) -> Rupture:
    """Return how a coupon breaks under one of these stresses, halfway to the one before."""
    reading = drawn(bench, coupon, stresses.tolist(), rupture=True)
    broken = reading.logs[f"ruptured of {BODY}"][:, 0] > 0.0
    intact = int(np.argmax(broken)) if broken.any() else len(broken)
    if intact == len(broken):
        raise Unmeasured(
            reading.stopped or f"it does not break up to {show(stresses[-1], PRESSURE)}"
        )
    if intact < 2:
        raise Unmeasured(f"it already breaks at {show(stresses[0], PRESSURE)}")
    curve = _curve(reading, coupon, stresses, intact)
    stress = 0.5 * (stresses[intact - 2] + stresses[intact - 1])
    (low, high), (start, stop) = curve.stress[-2:], curve.strain[-2:]
    slope = (stop - start) / (high - low)
    return Rupture(curve, float(stop + slope * (stress - high)), float(stress))


def compressed(bench: TestBench, coupon: Coupon) -> tuple[float, StressStrainCurve]:
    """Return the modulus [Pa] and the curve of a coupon between plates to which it sticks.

    Raises:
        Unmeasured: It does not resist.
    """
    parts = [-SMALL, *np.linspace(0.0, SHORTEST, 6)[1:]]
    script, before = ["at 0 s: settle", "at 0 s: fix lab x0"], 0.0
    for number, part in enumerate(parts):
        by, before = (part - before) * coupon.length, part
        script += [
            f"from {2 * number + 1} {TICK} to {2 * number + 2} {TICK}: "
            f"move lab x1 by ({by:.15g}, 0, 0) m using constant speed",
            f"at {2 * number + 2} {TICK}: settle",
        ]
    watched = [f"position of {name}" for name in (FIRST, SECOND, FRONT, BACK)]
    watched.append("force of lab x1")
    reading = bench.still(coupon, script, ("x0", "x1"), watched, 2 * len(parts))
    _refuse_stopped(reading)
    along = strains(reading, coupon)[0][::2]  # in between, plates move
    stress = reading.logs["force of lab x1"][::2, 0] / coupon.section
    pressure, shorter = stress[0] - stress[1], along[0] - along[1]
    if not (pressure > 0.0 and shorter > 0.0):
        raise Unmeasured("it has no resistance")
    return float(pressure / shorter), StressStrainCurve(_from_rest(along)[::-1], stress[::-1])


def _curve(
    reading: TestReading, coupon: Coupon, stresses: Floats, levels: int | None = None
) -> StressStrainCurve:
    along = _from_rest(strains(reading, coupon)[0])
    stress = np.concatenate([[0.0], stresses])[: len(along)]
    order = np.argsort(stress[:levels])
    return StressStrainCurve(along[:levels][order], stress[:levels][order])


def _from_rest(strain: Floats) -> Floats:
    """Return strains against the length at the first level, without a load."""
    return (1.0 + strain) / (1.0 + strain[0]) - 1.0


def _strongest(bench: TestBench, coupon: Coupon) -> float:
    """Return a stress that a coupon does not bear [Pa], at most twice what it bears.

    That is the one at which all springs through the middle would break at once; infinite if
    nothing breaks.
    """
    watched = [f"position of {FIRST}"]
    network = bench.rest(coupon, [[]], (), watched, rupture=True).network
    middle = 0.5 * coupon.length + 0.25 * coupon.cell
    x = network.position[network.springs.ends]
    along = x[:, 1] - x[:, 0]
    through = (x[:, :, 0].min(axis=1) < middle) & (x[:, :, 0].max(axis=1) > middle)
    part = np.abs(along[through, 0]) / np.linalg.norm(along[through], axis=1)
    return float(network.springs.strength[through] @ part) / coupon.section
