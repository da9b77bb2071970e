"""Steps of SciPy's solvers over one interval, with states inside each step."""

from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any

import numpy as np
from msgspec import Struct
from scipy import integrate

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
        solver = self._solver(time, y, stop, scales, tried)
        while solver.status == "running":
            start, before = solver.t, solver.y.copy()
            self._step(solver)
            self._slip(solver)
            self._effort.steps += 1
            land = self._landing(start, before, scales) if self._method in ONE_STEP else None
            yield Step(start, solver.t, before, solver.y.copy(), solver.dense_output, land)
            self._effort.evaluations += solver.nfev
            solver.nfev = 0

    def _landing(
        self, start: float, before: Floats, scales: ErrorScales
    ) -> Callable[[float], Floats]:
        def land(time: float) -> Floats:
            solver = self._solver(start, before, time, scales, time - start)
            while solver.status == "running":
                self._step(solver)
            self._effort.evaluations += solver.nfev
            return solver.y

        return land

    def _step(self, solver: Any) -> None:
        with np.errstate(all="ignore"):
            message = solver.step()
        if solver.status == "failed" or not np.isfinite(solver.y).all():
            reason = f" ({message})" if message else ""
            raise ReferenceFailure(f"SciPy's {self._method} failed at {solver.t:g} s{reason}")

    def _slip(self, solver: Any) -> None:
        """Let bristles of faces slip at the end of a step."""
        slipped = self._equations.slipped(solver.t, solver.y)
        if slipped is None:
            return
        if self._method not in ONE_STEP:
            raise ReferenceFailure(
                f"{self._method} uses steps before the last one and cannot follow the friction "
                "of faces; choose another method, such as Radau or DOP853"
            )
        solver.y = slipped
        solver.f = solver.fun(solver.t, slipped)  # which the next step begins with

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
