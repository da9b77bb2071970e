"""Steps of SciPy's solvers over one interval, with states inside, and slipping bristles.

Between two changes, each bristle of friction either sticks, z' = u, or slips: it bears G and
has the length G/k. It begins to slip when it is as long as that. It sticks again when G/k grows
faster than the surface lengthens it, u·e < (G/k)'.
"""

from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray
from scipy import integrate
from scipy.optimize import brentq

from tissuec.core.errors import TissueError
from tissuec.model.network import Floats
from tissuec.validate.equations import Equations, ErrorScales

METHODS = ("DOP853", "RK45", "RK23", "Radau", "BDF", "LSODA")
IMPLICIT = ("Radau", "BDF", "LSODA")
ONE_STEP = ("DOP853", "RK45", "RK23", "Radau")
LARGEST_FULL = 12_000  # unknowns for which LSODA's full matrix takes about 1 GB


class ReferenceFailure(TissueError):
    """SciPy's solver could not continue; the message says where and why."""


class Effort(Struct):
    """Cost of a reference: steps, evaluations of the forces, and wall time [s]."""

    steps: int = 0
    evaluations: int = 0
    wall_time: float = 0.0


class Step(Struct, frozen=True, eq=False, dict=True):
    """One accepted step from ``start`` to ``stop`` [s].

    Attributes:
        before, after: The unknowns at its ends.
        look: Makes the solver's interpolant; called before the next step is taken.
        land: The unknowns at a time within, integrated from the start; None where the method
            needs its past to step, so that only the interpolant is available.
    """

    start: float
    stop: float
    before: Floats
    after: Floats
    look: Callable[[], Callable[[float], Floats]]
    land: Callable[[float], Floats] | None

    @cached_property
    def _interpolant(self) -> Callable[[float], Floats]:
        return self.look()

    def near(self, time: float) -> Floats:
        """Return the unknowns at a time within the step, interpolated.

        They are in SI units and have the shape (unknown,).
        """
        if time <= self.start:
            return self.before
        return self.after if time >= self.stop else self._interpolant(time)

    def exact(self, time: float) -> Floats:
        """Return the unknowns at a time within the step as accurately as at its ends.

        They are in SI units and have the shape (unknown,).
        """
        if self.land is None or not self.start < time < self.stop:
            return self.near(time)
        return self.land(time)


class ReferenceStepper:
    """Steps the equations of one stretch.

    Args:
        equations: Of the stretch.
        method: One of ``METHODS``.
        rtol: Error per step that is allowed, relative to the scales of the motion.
        floor: Scales below which nothing matters.
        effort: Counts what is done.
    """

    def __init__(
        self, equations: Equations, method: str, rtol: float, floor: ErrorScales, effort: Effort
    ):
        self._equations, self._method, self._rtol, self._effort = (
            equations,
            method,
            rtol,
            effort,
        )
        self._floor, self._noise = floor, equations.noise()
        self._has_begun = False
        unknowns = 6 * len(equations.free) + equations.inner + 2
        if method == "LSODA" and unknowns > LARGEST_FULL:
            raise ReferenceFailure(
                f"LSODA keeps a full matrix of {unknowns} x {unknowns} numbers for this scene; "
                "choose another method, such as Radau or DOP853"
            )

    def steps(
        self, time: float, y: Floats, stop: float, scales: ErrorScales, first: float | None
    ) -> Iterator[Step]:
        """Yield the steps from a state to a time, at which the last step ends.

        Args:
            time: Time of the state [s].
            y: Unknowns in SI units, shape (unknown,).
            stop: End of the last step [s].
            scales: Scales of the motion so far.
            first: Size of the first step to try [s]; None lets the solver find one.
        """
        tried = None if first is None else min(first, stop - time)
        slips, y = self._equations.cut is not None, self._begun(time, y)
        solver = self._solver(time, y, stop, scales, tried)
        while solver.status == "running":
            start, before = solver.t, solver.y.copy()
            self._step(solver)
            self._effort.steps += 1
            land = self._landing(start, before, scales) if self._method in ONE_STEP else None
            step = Step(start, solver.t, before, solver.y.copy(), solver.dense_output, land)
            if slips:
                step = self._until_slip(step)
            yield step
            self._effort.evaluations += solver.nfev
            solver.nfev = 0
            if step.stop < solver.t:
                size = min(solver.t - start, stop - step.stop)
                solver = self._solver(step.stop, step.after, stop, scales, size)
            elif slips:
                solver.y = step.after
                solver.f = solver.fun(solver.t, step.after)  # which the next step begins with

    def _landing(
        self, start: float, before: Floats, scales: ErrorScales
    ) -> Callable[[float], Floats]:
        cut = self._equations.cut
        begun = None if cut is None else cut.slides

        def integrated(time: float) -> Floats:
            solver = self._solver(start, before, time, scales, time - start)
            while solver.status == "running":
                self._step(solver)
            self._effort.evaluations += solver.nfev
            return solver.y

        def land(time: float) -> Floats:
            if cut is None or begun is None:
                return integrated(time)
            ended, cut.slides = cut.slides, begun
            found = integrated(time)
            cut.slides = ended
            return found

        return land

    def _step(self, solver: Any) -> None:
        with np.errstate(all="ignore"):
            message = solver.step()
        if solver.status == "failed" or not np.isfinite(solver.y).all():
            reason = f" ({message})" if message else ""
            raise ReferenceFailure(f"SciPy's {self._method} failed at {solver.t:g} s{reason}")

    # --- friction of faces ------------------------------------------------------------------

    def _begun(self, time: float, y: Floats) -> Floats:
        """Return the unknowns at the first step [s] with bristles that slip or stick."""
        if self._equations.cut is None or self._has_begun:
            return y
        if self._method not in ONE_STEP:
            raise ReferenceFailure(
                f"{self._method} uses steps before the last one and cannot follow the friction "
                "of faces; choose another method, such as Radau or DOP853"
            )
        self._has_begun = True
        return self._equations.slipped(time, y)

    def _until_slip(self, step: Step) -> Step:
        """Return a step up to where a bristle begins to slip or to stick."""
        step.near(0.5 * (step.start + step.stop))  # while bristles are as they were within
        change = first_change(self._equations, step.start, step.stop, step.near)
        stop, after, changed = step.stop, step.after, np.zeros(1, dtype=bool)
        if change is not None:
            stop, after, changed = change.time, step.exact(change.time), change.changed
        slipped = self._equations.slipped(stop, after, changed)
        return Step(step.start, stop, step.before, slipped, lambda: step.near, step.land)

    def _solver(
        self, time: float, y: Floats, stop: float, scales: ErrorScales, first: float | None
    ) -> Any:
        keywords: dict[str, Any] = {"rtol": self._rtol, "atol": self._allowed(scales)}
        if self._method in IMPLICIT:
            matrix = self._equations.jacobian

            def full(t: float, z: Floats) -> Floats:
                return matrix(t, z).toarray()

            # LSODA knows full and banded matrices only.
            keywords["jac"] = full if self._method == "LSODA" else matrix
        make = getattr(integrate, self._method)
        return make(self._equations.rate, time, y, stop, first_step=first, **keywords)

    def _allowed(self, scales: ErrorScales) -> Floats:
        """Return the absolute error allowed per step, never less than rounding makes anyway."""
        size, noise = scales.joined(self._floor), self._noise
        place = max(self._rtol * size.displacement, noise.displacement)
        speed = max(self._rtol * size.speed, noise.speed)
        energy = max(self._rtol * size.energy, noise.energy)
        equations = self._equations
        count, bristles = 3 * len(equations.free), 3 * len(equations.memory)
        given = equations.yielding.count
        before = np.repeat([place, speed, speed, place], [count, count, bristles, given])
        return np.concatenate([before, equations.relaxing.allowed(place), [energy, energy]])


LOOKS = 8  # in a step
LATE = 1e-9  # part of the largest G/k by which bristles are longer when they begin to slip
SHARP = 1e-10  # part of a step to which a change is located


class SlipChange(NamedTuple):
    """The first change in a step.

    Attributes:
        time: When it happens [s].
        changed: Which bristles slip or stick from then on, shape (bristle,).
    """

    time: float
    changed: NDArray[np.bool_]


def first_change(
    equations: Equations, start: float, stop: float, near: Callable[[float], Floats]
) -> SlipChange | None:
    """Return the first change of a bristle in a step, if there is one.

    Args:
        equations: Of the stretch.
        start, stop: Of the step [s].
        near: Returns the unknowns at a time within [s], in SI units, shape (unknown,).
    """
    step, before = _SlipStep(equations, start, stop, near), start
    for time in np.linspace(start, stop, LOOKS + 1)[1:]:
        if step.excess(time).max() > 0.0:
            when = step.crossing(before, time)
            return SlipChange(when, step.excess(when) > 0.0)
        before = time
    return None


class _SlipStep:
    """A step in which bristles stick or slip; for arguments see ``first_change``."""

    def __init__(
        self, equations: Equations, start: float, stop: float, near: Callable[[float], Floats]
    ):
        assert equations.cut is not None, "otherwise nothing slips"
        self._equations, self._cut, self._near = equations, equations.cut, near
        self._start, self._stop, self._size = start, stop, stop - start

    def crossing(self, low: float, high: float) -> float:
        """Return a time just after the largest excess becomes positive [s]."""

        def largest(time: float) -> float:
            return float(self.excess(time).max())

        if largest(low) < 0.0:
            low = float(brentq(largest, low, high, xtol=SHARP * self._size))
        way = SHARP * self._size
        while low + way < high and largest(low + way) <= 0.0:
            way *= 2.0
        return min(low + way, high)

    def excess(self, time: float) -> Floats:
        """Return how far bristles are beyond a change [m], shape (bristle,)."""
        length, most, ahead = self._lengths(time)
        slides, late = self._cut.slides, LATE * most.max()
        excess: Floats = np.where(slides | (most == 0.0), 0.0, length - most) - late
        sticks: Floats = -ahead * self._size - late
        return np.where(slides & (ahead < 0.0), sticks, excess)

    def _lengths(self, time: float) -> tuple[Floats, Floats, Floats]:
        """Return lengths [m], those at which bristles slip [m] and their growth [m/s]."""
        moved, velocity = self._equations.spread(time, self._near(time))
        return self._cut.lengths(self._equations.drawn + moved, velocity)
