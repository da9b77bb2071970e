"""The solution of a reference: states at given times, and events."""

from collections.abc import Mapping

import numpy as np
from msgspec import Struct

from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices
from tissuec.validate.crossings import Break
from tissuec.validate.equations import Equations, ErrorScales, ReferenceEnergies, SpringStates
from tissuec.validate.stepping import Effort

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
        self.velocity[row] = velocity
        self.force[row] = equations.inner_forces(self.due, moved, velocity, springs)
        self.sizes[row] = self.scales.displacement, self.scales.speed
        self.energies[row] = *energies, *y[-2:], switched
        self.holders.append(holders)
        self.row += 1


def standing_energy(state: State) -> float:
    """Return the energy of a state [J]."""
    equations = Equations(state, state.time)
    moved = state.position - state.network.position
    return equations.energies(state.time, moved, state.velocity).total
