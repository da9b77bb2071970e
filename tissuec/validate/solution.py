"""The solution of a reference: states at given times, and events found within its steps.

The interpolant of a step says about where; the time itself is found on states that were
integrated there, since an interpolant is less exact than the steps.
"""

from collections.abc import Callable, Mapping

import numpy as np
from msgspec import Struct
from scipy.optimize import brentq, minimize_scalar

from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices
from tissuec.validate.equations import Equations, ErrorScales, ReferenceEnergies, SpringStates
from tissuec.validate.stepping import Effort, Step

COARSE, FINE = 8, 64  # pieces in which a step is examined
SUSPECT = 0.97  # of what breaks them: springs that are examined closely
TOGETHER = 1e-11  # springs this near to their limits break with the one that breaks
ROUNDING = np.float64(4.0 * np.finfo(float).eps)  # the finest that brentq takes
NEAR = 1e-6  # of the step: crossings this near to the first one may be the first


class Break(Struct, frozen=True, eq=False):
    """Springs and elements that broke by themselves at a time [s]."""

    time: float
    springs: Indices  # ascending


class Strains:
    """What can break in a stretch, springs and then elements, and how near to that it came.

    Attributes:
        springs: Their numbers as entities, shape (able,).
        highest: Largest load so far, shape (able,).
    """

    def __init__(self, equations: Equations):
        self._equations = equations
        breaks = np.isfinite(equations.strength) | np.isfinite(equations.crush)
        self._able = np.flatnonzero(breaks)
        self.springs = np.concatenate([equations.springs[self._able], equations.breakable])
        self.highest = np.zeros(len(self.springs))

    def at(self, time: float, y: Floats) -> Floats:
        """Return loads divided by their limits, dimensionless, shape (able,).

        Args:
            time: Time [s].
            y: Unknowns, see ``Equations``.
        """
        equations = self._equations
        moved, velocity = equations.spread(time, y)
        burdens = np.zeros(0)
        if len(self._able):
            springs = equations.pull(time, moved, velocity)
            burdens = equations.burdens(springs)[self._able]
        return np.concatenate([burdens, equations.element_burdens(moved)])

    def first_break(self, step: Step) -> Break | None:
        """Return the first break within a step, with all springs that break at that time."""
        times = np.linspace(step.start, step.stop, COARSE + 1)
        seen = np.array([self.at(time, step.near(time)) for time in times])
        highest = seen.max(axis=0, initial=0.0)
        suspects = np.flatnonzero(highest > SUSPECT)
        found = self._crossing(step, suspects) if len(suspects) else None
        if found is None:
            self.highest = np.maximum(self.highest, highest)
            return None
        loads = self.at(found[0], step.exact(found[0]))
        self.highest = np.maximum(self.highest, loads)
        broken = loads >= 1.0 - TOGETHER
        broken[found[1]] = True
        return Break(found[0], np.sort(self.springs[broken]))

    def _crossing(self, step: Step, suspects: Indices) -> tuple[float, int] | None:
        """Return the time of the first crossing and the spring, as a place in ``springs``."""
        times = np.linspace(step.start, step.stop, FINE + 1)
        seen = np.array([self.at(time, step.near(time))[suspects] for time in times])
        brackets: list[tuple[float, float, int]] = []
        for column, spring in enumerate(suspects.tolist()):
            bracket = self._bracket(step, times, seen[:, column], spring)
            if bracket is not None:
                brackets.append((*bracket, spring))
        if not brackets:
            return None
        about = [self._root(step.near, bracket) for bracket in brackets]
        nearest = min(about) + NEAR * (step.stop - step.start)
        return min(
            (self._root(step.exact, bracket), bracket[2])
            for bracket, guess in zip(brackets, about, strict=True)
            if guess <= nearest
        )

    def _bracket(
        self, step: Step, times: Floats, seen: Floats, spring: int
    ) -> tuple[float, float] | None:
        """Return times before and after the first crossing of one spring."""
        for i in range(len(times) - 1):
            if seen[i + 1] > 1.0:
                return times[i], times[i + 1]
            peaks = i > 0 and seen[i] >= seen[i - 1] and seen[i] >= seen[i + 1]
            if (
                peaks
                and (top := self._top(step, times[i - 1], times[i + 1], spring)) is not None
            ):
                return times[i - 1], top
        return None

    def _top(self, step: Step, low: float, high: float, spring: int) -> float | None:
        """Return when the load is largest, if it is above what breaks the spring then."""
        best = minimize_scalar(
            lambda t: -self.at(t, step.near(t))[spring],
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-7 * (high - low)},
        )
        return float(best.x) if -best.fun > 1.0 else None

    def _root(
        self, state: Callable[[float], Floats], bracket: tuple[float, float, int]
    ) -> float:
        """Return when one spring reaches what breaks it."""
        low, high, spring = bracket

        def excess(time: float) -> float:
            return float(self.at(time, state(time))[spring]) - 1.0

        # What the interpolant brackets may lie beside it by its error.
        if excess(low) >= 0.0:
            return low
        if excess(high) <= 0.0:
            return high
        root = brentq(excess, low, high, xtol=1e-15 * (high - low), rtol=ROUNDING)
        return float(np.asarray(root))


def first_true(
    holds: Callable[[float, Floats], bool], step: Step, stop: float, resolution: float
) -> float | None:
    """Return the first time in a step, up to ``stop``, at which a condition holds.

    Args:
        holds: Condition as a function of the time [s] and the unknowns then.
        stop: Last time of interest [s].
        resolution: Accuracy of the result [s].

    Returns:
        The time [s], None if there is none.
    """
    times = np.linspace(step.start, stop, COARSE // 2 + 1)
    true = next((i for i in range(1, len(times)) if holds(times[i], step.near(times[i]))), None)
    if true is None:
        return None
    low, high = float(times[true - 1]), float(times[true])
    while high - low > resolution and low < (middle := 0.5 * (low + high)) < high:
        if holds(middle, step.exact(middle)):
            high = middle
        else:
            low = middle
    return high


Holders = tuple[Mapping[str, Indices], ...]


class TriggerFiring(Struct, frozen=True):
    """A trigger, by its place in the plan, and when it fired [s]."""

    time: float
    trigger: int


class Reference(Struct, frozen=True, eq=False):
    """A solution at given times.

    Attributes:
        method, rtol: How it was found.
        times: [s], shape (row,).
        position, velocity: [m], [m/s], shape (row, node, 3).
        force: Sum of the spring forces on every node [N], shape (row, node, 3).
        holders: Who holds which nodes, for each row.
        displacement, speed: Largest so far [m], [m/s], shape (row,).
        energies: Kinetic, elastic and gravity energy, work, dissipated and switched energy [J],
            shape (row, 6).
        initial: Energy after the events at 0 s [J].
        breaks: Springs that broke.
        firings: Triggers that fired.
        strain: Largest tension or pressure over the force that breaks, of each spring, shape
            (spring,).
        effort: What it cost.
    """

    method: str
    rtol: float
    times: Floats
    position: Floats
    velocity: Floats
    force: Floats
    holders: Holders
    displacement: Floats
    speed: Floats
    energies: Floats
    initial: float
    breaks: tuple[Break, ...]
    firings: tuple[TriggerFiring, ...]
    strain: Floats
    effort: Effort

    @property
    def imbalance(self) -> Floats:
        """Return the energy that is there and should not be [J], shape (row,)."""
        kinetic, elastic, gravity, work, lost, switched = self.energies.T
        return kinetic + elastic + gravity - (self.initial + work - lost + switched)


class Track:
    """Rows that are filled one after the other.

    Attributes:
        row: The first that is empty.
        scales: How large the motion was until now.
    """

    def __init__(self, times: Floats, nodes: int):
        shape = (len(times), nodes, 3)
        self.times = times
        self.position, self.velocity, self.force = (np.empty(shape) for _ in range(3))
        self.sizes, self.energies = np.empty((len(times), 2)), np.empty((len(times), 6))
        self.holders: list[Mapping[str, Indices]] = []
        self.row = 0
        self.scales = ErrorScales(0.0, 0.0, 0.0)

    @property
    def due(self) -> float:
        """Return the time of the first empty row [s]; infinite if all are full."""
        return self.times[self.row] if self.row < len(self.times) else float("inf")

    def measure(
        self, equations: Equations, time: float, y: Floats, springs: SpringStates | None = None
    ) -> ReferenceEnergies:
        """Update the largest displacement, speed and energy with a state; return its energies.

        Args:
            equations: The equations of motion.
            time: Time [s].
            y: Unknowns in SI units, shape (6 free + inner + 2,).
            springs: State of the springs, if it is known.
        """
        moved, velocity = equations.spread(time, y)
        energies = equations.energies(time, moved, velocity, springs)
        self.scales = self.scales.joined(equations.scales(moved, velocity, energies))
        return energies

    def enter(
        self,
        equations: Equations,
        y: Floats,
        holders: Mapping[str, Indices],
        switched: float,
    ) -> None:
        """Set the next row to the state at its time.

        Args:
            equations: The equations of motion.
            y: Unknowns in SI units, shape (6 free + inner + 2,).
            holders: Nodes that are held, by holder, shape (n,) each.
            switched: Energy that events added so far [J].
        """
        row = self.row
        moved, velocity = equations.spread(self.due, y)
        springs = equations.pull(self.due, moved, velocity)
        energies = self.measure(equations, self.due, y, springs)
        self.position[row] = equations.drawn + moved
        self.velocity[row] = velocity[: equations.count]
        self.force[row] = equations.inner_forces(self.due, moved, velocity, springs)
        self.sizes[row] = self.scales.displacement, self.scales.speed
        self.energies[row] = *energies, *y[-2:], switched
        self.holders.append(holders)
        self.row += 1


def standing_energy(state: State) -> float:
    """Return the energy of a state [J]."""
    equations = Equations(state, state.time)
    moved = state.position - state.drawn
    return equations.energies(state.time, moved, state.velocity).total
