"""Tests of solids that consist of elements, also relaxation after a sudden shear.

All nodes of the sheared cube are held or moved, so nothing oscillates and its volume is
constant: the stress relaxes like the shear modulus. With branches of shares s and times τ, and
a ramp of duration d, the share of the stress at its end that remains after the time t is

    (1 - Σ s + Σ s c exp(-t/τ)) / (1 - Σ s + Σ s c),    c = (1 - exp(-d/τ)) τ/d.

(R. M. Christensen, Theory of Viscoelasticity, 1982, chapter 1.) Only the ratio of the times
counts, so runs are in scaled time, in which the shortest relaxation time is at most 0.1 s:
steps are as short as those of the elastic cube, however long it is held.
"""

from collections.abc import Iterator, Sequence
from math import isfinite, nan
from typing import NamedTuple

import numpy as np

from tissuec.analysis.lab import homogeneous, indentation, motion
from tissuec.analysis.lab.bench import TestBench, Unmeasured
from tissuec.analysis.lab.examiner import OTHERS, Examiner, Listener, Values
from tissuec.analysis.lab.homogeneous import SIDE, Cube, CubeResponse
from tissuec.analysis.lab.rows import SHARE, Examination, LabCurve, known_of
from tissuec.analysis.lab.spring_tests import BY_LAYER
from tissuec.analysis.lab.statics import TensionTest
from tissuec.core.names import key_of
from tissuec.core.structs import replace
from tissuec.model.inelastic import TIMES
from tissuec.model.network import Floats
from tissuec.scene.tissues.known_curves import ACROSS, COMPRESSION, EQUIBIAXIAL, SHEAR, TENSION
from tissuec.scene.tissues.quantities import SHARES, TOGETHER

_CELLS = 3  # across a bar that oscillates; its decay hardly depends on the mesh
_COUPONS = "one element where strain is the same everywhere; otherwise two meshes"


class SolidExaminer(Examiner):
    """Tests of cubes of one element, and of blocks and bars on two meshes.

    Measurements on cubes are checked by the closed form of the law.

    Args:
        bench: The bench of the tissue.
        listener: Callback for each row.
    """

    beside = "the law differs"

    def __init__(self, bench: TestBench, listener: Listener):
        super().__init__(bench, _COUPONS, listener)
        self.tension: TensionTest | None = None  # across fibres, if it has any

    def all(self) -> Examination:
        """Return the results of all tests, each after those that it depends on."""
        if not self._draw():
            return self.found  # all others need its modulus
        self._load(COMPRESSION, COMPRESSION, "Young's modulus")
        self._load(SHEAR, SHEAR, "shear modulus")
        if self.bench.has_fibres:
            self._load("tension across", ACROSS, "Young's modulus")
            self.note("no test of equibiaxial tension: fibres make it uneven")
        else:
            self._load(EQUIBIAXIAL, EQUIBIAXIAL, "")
        self.beside = "the meshes differ"
        self._press()
        self._motion()
        self.note_what_was_left_out()
        return self.found

    # --- cubes --------------------------------------------------------------------------------

    def _draw(self) -> bool:
        """Stretch a cube until it breaks, if it does; return whether it could be measured."""
        tears = self._tears()
        found: list[CubeResponse] = []

        def draw() -> tuple[Values, Values]:
            found.append(homogeneous.loaded(self.bench, TENSION, tears=tears))
            one = found[0]
            measured = {self.along: one.modulus[0], "Poisson's ratio": one.ratio[0]}
            check = {self.along: one.modulus[1], "Poisson's ratio": one.ratio[1]}
            if not self.bench.lacks("mass"):
                measured["density"] = one.density
            return measured, check

        if not self.attempt("tension", draw):
            return False
        one = found[0]
        self.tension = TensionTest(one.modulus[0], one.ratio[0], one.density)
        self.keep_curve("tension", one.curve, one.why)
        if tears or self._knows_of_rupture():
            why = one.why if tears and not isfinite(one.rupture[0]) else ""
            both = zip(TOGETHER, one.rupture_by_law, one.rupture, strict=True)
            for quantity, check, measured in both:
                self.add("tearing", quantity, check, measured, why, SHARE)
        return True

    def _tears(self) -> bool:
        """Return whether a cube is stretched until it breaks; if not, note why."""
        if not self.bench.breaks_without_crack:
            self.note("no test of tearing: a cube without a crack does not measure toughness")
            return False
        if self.bench.yields:
            self.note(
                "no test of tearing: elements that yield bear little more than that stress"
            )
            return False
        return self._has_limit()

    def _has_limit(self) -> bool:
        given = self.bench.tissue.given
        return any(key in given and isfinite(given[key].value) for key in TOGETHER)

    def _knows_of_rupture(self) -> bool:
        known = {key_of(one.quantity.name) for one in self.bench.tissue.known}
        return bool(known.intersection(TOGETHER)) and not self.bench.yields

    def _load(self, name: str, mode: str, quantity: str) -> None:
        """Load a cube in a mode, and add its modulus and its curve."""
        found: list[CubeResponse] = []

        def load() -> tuple[Values, Values]:
            found.append(homogeneous.loaded(self.bench, mode))
            if not quantity:
                return {}, {}
            return {quantity: found[0].modulus[0]}, {quantity: found[0].modulus[1]}

        if self.attempt(name, load):
            self.keep_curve(name, found[0].curve, found[0].why)
            if mode == ACROSS:
                one = found[0]
                self.tension = TensionTest(one.modulus[0], one.ratio[0], one.density)

    # --- two meshes ---------------------------------------------------------------------------

    def _press(self) -> None:
        if self.bench.has_fibres:
            self.note("no indentation test: its theory holds for tissue without fibres")
            return
        coarse, fine = indentation.blocks(self.bench)

        def press() -> tuple[Values, Values]:
            assert self.tension is not None
            check, measured = (
                {"Young's modulus": indentation.indentation(self.bench, one, self.tension)}
                for one in (coarse, fine)
            )
            return measured, check

        self.attempt("indentation", press, BY_LAYER)

    def _motion(self) -> None:
        """Test relaxation if the tissue relaxes, otherwise oscillation across fibres."""
        if branches_of(self.bench):
            self._relax()
            return
        self._stay()
        lacking = [what for what in ("mass", "viscosity") if self.bench.lacks(what)]
        if lacking:
            self.note(f"no dynamic tests: the tissue has no {' and no '.join(lacking)}")
            return
        assert self.tension is not None
        tension = self.tension
        coarse, fine = self.bench.coupons(motion.width_for(self.bench, tension), "y")
        coupons = coarse, replace(fine, cells=_CELLS)

        def let_go() -> tuple[Values, Values]:
            check, measured = (motion.let_go(self.bench, one, tension) for one in coupons)
            return measured, check

        self.attempt("oscillation", let_go)

    def _stay(self) -> None:
        """Compare a tissue that does not relax with evidence on its relaxation."""
        known = known_of(self.found.tissue, "")
        if known:
            place = np.unique([place for one in known for place in one.places])
            all_left = np.ones_like(place)
            self.keep_curve("ramp and hold", LabCurve("", place, all_left, all_left, known), "")

    def _relax(self) -> None:
        names = (
            tuple(OTHERS)
            if TIMES[1] in self.bench.tissue.given
            else ("relaxing share", TIMES[0])
        )
        self.beside = "the law differs"
        try:
            found = relaxed(self.bench)
        except Unmeasured as reason:
            self.add("ramp and hold", "", nan, nan, str(reason), SHARE)
            return
        measured, check = zip(found.share, found.time, strict=True)
        self.attempt(
            "ramp and hold",
            lambda: (
                dict(zip(names, measured, strict=True)),
                dict(zip(names, check, strict=True)),
            ),
        )
        self.keep_curve("ramp and hold", found.curve, "it was not held longer")


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
