"""Relaxation of a cube that is sheared suddenly and held.

All of its nodes are held or moved, so nothing oscillates and its volume is constant: the stress
relaxes like the shear modulus. With branches of shares s and times τ, and a ramp of duration d,
the share of the stress at its end that remains after the time t is

    (1 - Σ s + Σ s c exp(-t/τ)) / (1 - Σ s + Σ s c),    c = (1 - exp(-d/τ)) τ/d.

(R. M. Christensen, Theory of Viscoelasticity, 1982, chapter 1.) Only the ratio of the times
counts, so runs are in scaled time, in which the shortest relaxation time is at most 0.1 s:
steps are as short as those of the elastic cube, however long it is held.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from tissuec.analysis.lab.bench import TestBench, Unmeasured
from tissuec.analysis.lab.cube import SIDE, Cube
from tissuec.analysis.lab.rows import LabCurve, known_of
from tissuec.model.inelastic import TIMES
from tissuec.model.network import Floats
from tissuec.scene.tissues.quantities import SHARES

AMOUNT = 0.01  # of shear
_RAMP = 0.02  # of the shortest relaxation time
_SAMPLES = 300  # of one run
_LONGER = 30.0  # one run than the one before it, at least
_SHORTEST = 0.1  # relaxation time of a run [s]
_RELAXED = 5.0  # relaxation times, after which nothing is left

Branches = Sequence[tuple[float, float]]  # share and time [s] of each


class RelaxedCube(NamedTuple):
    """Relaxation of the stress of a cube.

    Attributes:
        curve: Remaining shares of the stress, over times after the ramp.
        share: The share that is lost in the end, and the same by the law.
        time: The time in which all but 1/e of that is lost [s], and the same by the law.
    """

    curve: LabCurve
    share: tuple[float, float]
    time: tuple[float, float]


def branches_of(bench: TestBench) -> Branches:
    """Return the shares and times of the branches of a tissue that relax."""
    given = {key: one.value for key, one in bench.tissue.given.items()}
    pairs = zip(SHARES, TIMES, strict=True)
    return [(given[share], given[time]) for share, time in pairs if given.get(share)]


def relaxed(bench: TestBench) -> RelaxedCube:
    """Return the relaxation of a cube of a tissue with branches.

    Raises:
        Unmeasured: A run stopped.
    """
    branches, known = branches_of(bench), known_of(bench.tissue, "")
    scale = min(1.0, _SHORTEST / min(time for _, time in branches))
    ramp = _RAMP * min(time for _, time in branches)
    ends = [_RELAXED * time for _, time in branches] + [one.places[-1] for one in known]
    place, stress = np.zeros(0), np.zeros(0)
    for duration in _durations(ends):
        time, found = _held(bench, ramp, duration, scale)
        later = time > (place[-1] if len(place) else -1.0)
        place, stress = np.append(place, time[later]), np.append(stress, found[later])
    left, check = stress / stress[0], left_by_law(branches, ramp, place)
    shares = 1.0 - float(left[-1]), 1.0 - float(check[-1])
    times = _time_of(place, left), _time_of(place, check)
    # The first place is the end of the ramp, where all is left.
    curve = LabCurve("", place[1:], left[1:], check[1:], known)
    return RelaxedCube(curve, shares, times)


def _durations(ends: Sequence[float]) -> Iterator[float]:
    """Yield durations of runs, each much longer than the one before."""
    longest, last = max(ends), 0.0
    for end in sorted(ends):
        if end >= _LONGER * last and longest >= _LONGER * end:
            last = end
            yield end
    yield longest


def _held(
    bench: TestBench, ramp: float, duration: float, scale: float
) -> tuple[Floats, Floats]:
    """Return times since the end of a ramp [s], and stresses [Pa], shape (time,) each.

    Args:
        ramp, duration: Of the ramp and of the hold [s].
        scale: Times of the run per time of the tissue.
    """
    given = bench.tissue.given
    times = tuple((name, scale * given[name].value) for name in TIMES if name in given)
    ramp, duration = scale * ramp, scale * duration
    interval = duration / _SAMPLES
    begins = interval * np.ceil(ramp / interval)  # so that the ramp ends at a sample
    reading = bench.run(
        Cube(bench.has_fibres, bench.is_prestressed, is_inviscid=True, times=times),
        [
            "at 0 s: fix lab y0",
            f"from {begins - ramp:.15g} s to {begins:.15g} s: move lab y1 by "
            f"({AMOUNT * SIDE:.15g}, 0, 0) m using constant speed",
        ],
        ("y0", "y1"),
        ["force of lab y1"],
        f"duration = {begins + duration + interval:.15g} s; integrator is automatic",
        interval=f"{interval:.15g} s",
    )
    if reading.stopped:
        raise Unmeasured(reading.stopped)
    force = reading.logs["force of lab y1"][:, 0]
    start = round(begins / interval)
    return (reading.time[start:] - begins) / scale, force[start:] / SIDE**2


def left_by_law(branches: Branches, ramp: float, time: Floats) -> Floats:
    """Return the share of the stress that remains after a ramp; see the module.

    Args:
        branches: The branches.
        ramp: Duration of the ramp [s].
        time: Since its end [s], shape (time,).
    """
    share, tau = np.array(branches).T
    begun = share * -np.expm1(-ramp / tau) * tau / ramp
    rest = 1.0 - share.sum()
    return (rest + np.exp(-time[:, None] / tau) @ begun) / (rest + begun.sum())


def _time_of(place: Floats, left: Floats) -> float:
    """Return the time in which all but 1/e of the relaxing stress is lost [s]."""
    above = left - left[-1]
    after = int(np.argmax(above <= np.exp(-1.0) * above[0]))
    (late, early), (low, high) = place[[after, after - 1]], above[[after, after - 1]]
    part = (np.exp(-1.0) * above[0] - low) / (high - low)
    return float(late + part * (early - late))
