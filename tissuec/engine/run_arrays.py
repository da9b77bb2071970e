"""Arrays and numbers of the stepping code: initial ones, and the buffer of samples."""

from collections.abc import Callable, Iterator
from copy import deepcopy
from math import inf, sqrt
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from tissuec.compiled.record_tables import aligned_zeros
from tissuec.core.structs import replace
from tissuec.engine.integrators import Integrator
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.layout import Layout
from tissuec.engine.method import Samples
from tissuec.engine.unknowns import no_solver
from tissuec.forces.springs.springs import measured
from tissuec.kernels.records import GLANCES, Buffer, Progress, Tableau, Task, Team, Work
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Network
from tissuec.script.procedures import PropagationChoices

BUFFER_BYTES = 32_000_000
FLOOR = 1e-6  # of the drawing: displacements below are no measure of errors
# Sums of work are to be true of smaller motions as well: of those of which rounding leaves more
# digits than the tolerance requires.
LEDGER_FLOOR, LEDGER_DIGITS = 1e-8, 1e-12
JOLT = 0.005  # of the tolerance: change of speeds where a spring turns over, which may live on
TINIEST = 1e-290  # [m], so that nothing is divided by zero
# Part of the tolerance that errors of implicit steps may use up while displacements grow, not
# in time; explicit ones may miss forces that swing as they grow.
GROWTH = 0.5
# Share of a step (that of ``dop853`` at a tolerance of 1e-5) below which bristles of nodes are
# velocities where contacts change, for methods that estimate errors of these.
FINE = 3.9e-8
INSIDE = 0.5  # of the tolerance: errors of samples within steps
# What errors of a step are put down to rounding, of the coordinates. Fine tolerances would be
# missed by what slow motions add up of it; less than half of a unit in the last place is noise.
ROUNDING, LEAST_ROUNDING = 8 * float(np.finfo(float).eps), 0.5 * float(np.finfo(float).eps)


def new_work(
    integrator: type[Integrator], network: Network, team: Team, layout: Layout
) -> Work:
    """Return arrays of zeros, with the coefficients of an integrator.

    Args:
        team: Threads that share loops.
        layout: Of nodes and internal variables in the arrays.
    """
    rows = integrator.rows
    return Work(
        **_of_nodes(rows, network, layout),
        ledger=np.zeros((2, 2)),
        end_row=integrator.end_row,
        power=np.zeros((rows, 2)),
        trial_ledger=np.zeros(2),
        tableau=cast(Tableau, deepcopy(integrator.tableau)),  # None where nothing reads it
        choices=PropagationChoices().row(),
        dense_x=integrator.dense_x.copy(),
        dense_v=integrator.dense_v.copy(),
        embedded_x=integrator.embedded_x.copy(),
        embedded_v=slopes(integrator.embedded_x),
        weights=np.zeros((2, rows)),
        tension=np.zeros((3, 0)),
        booked=np.zeros((2, 2)),
        trend=np.full(2, np.nan),
        effort=np.zeros(5, dtype=np.int64),
        pieces=np.zeros(1, dtype=np.int64),
        sides=np.zeros((2, 3, 0)),
        doubt=np.zeros(1),
        errors=np.zeros(2),
        goal=np.zeros(2),
        rate=np.zeros(1),
        solver=no_solver(),
        team=team,
    )


def _of_nodes(rows: int, network: Network, layout: Layout) -> dict[str, Floats]:
    """Return the arrays of zeros of ``Work`` that have a vector or a number for each place."""
    places, tools = len(layout.order), network.node_count - network.body_nodes
    size = 3 * places
    return {
        "moving": aligned_zeros(layout.bodies),
        "x": aligned_zeros(2, size),
        "v": aligned_zeros(2, size),
        "a": aligned_zeros(2, size),
        "origin": aligned_zeros(size),
        "drift": aligned_zeros(size),
        "rows": aligned_zeros(rows, size),
        "trial_x": aligned_zeros(size),
        "trial_v": aligned_zeros(size),
        "zero": aligned_zeros(size),
        "each": aligned_zeros(places - tools),
        "inner": aligned_zeros(3, size),
    }


def moved_work(work: Work, network: Network, layout: Layout, **vectors: Floats) -> Work:
    """Return arrays with other places of nodes, between two steps.

    Args:
        work: As it was.
        layout: Of the nodes from now on.
        vectors: ``x`` [m], ``v`` [m/s], ``a`` [m/s²], ``origin`` [m] and ``drift`` [m/s] by
            their new places, shape (3 place,).
    """
    made = _of_nodes(len(work.rows), network, layout)
    for name, vector in vectors.items():
        made[name][:] = vector
    made["trial_x"][:], made["trial_v"][:] = vectors["x"], vectors["v"]
    return work._replace(**made)


def new_progress(time: float) -> Progress:
    """Return the progress of a run that begins at a time [s]; its step is still 0."""
    return Progress(
        time=time,
        step=0.0,
        end=time,
        memory=0.0,
        wait=0,
        displacement=0.0,
        displacement_before=0.0,
        speed=0.0,
        speed_before=0.0,
        speed_now=0.0,
        leeway=0.0,
        current=0,
        pending=0,
        prepared=0,
        fresh=1,
        accepted=0,
        rejected=0,
        sample=0,
        filled=0,
        smallest=inf,
        largest=0.0,
        energy=0.0,
        error=0.0,
        room=0.0,
        usual=0.0,
        bends=0,
        glanced=0,
    )


def new_buffer(times: Floats, node_count: int, spring_count: int) -> Buffer:
    """Return an empty buffer for samples, of bounded size.

    Args:
        times: Times of all samples of the run [s], shape (sample,).
        node_count: Number of nodes.
        spring_count: Number of springs.
    """
    room = BUFFER_BYTES // (8 * (6 * node_count + 4 * spring_count + 3))
    count = max(2, min(room, 2 * len(times)))
    size = 3 * node_count
    return Buffer(
        times=np.array(times, dtype=float),
        time=np.zeros(count),
        position=np.zeros((count, size)),
        velocity=np.zeros((count, size)),
        ledger=np.zeros((count, 2)),
        error=np.zeros(count),
        reach=np.zeros(count),
        doubtful=np.zeros(count, dtype=np.int64),
        **glances(0, size),
    )


def glances(steps: int, size: int) -> dict[str, Floats]:
    """Return zeros for the states within some steps, as in ``Buffer``.

    Args:
        steps: Number of steps.
        size: Number of components, 3 node.

    Returns:
        Times [s], shape (glance,), positions [m] and velocities [m/s], shape (glance, size).
    """
    count = GLANCES * steps
    return {
        "glance_time": np.zeros(count),
        "glance_position": np.zeros((count, size)),
        "glance_velocity": np.zeros((count, size)),
    }


def arrays_of(record: tuple[Any, ...]) -> Iterator[NDArray[Any]]:
    """Yield the arrays of a record and of records within it, of any shape and unit."""
    for value in record:
        if isinstance(value, np.ndarray):
            yield value
        elif isinstance(value, tuple):
            part = cast("tuple[Any, ...]", value)
            yield from arrays_of(part)


def slopes(table: Floats) -> Floats:
    """Return derivatives of polynomials without first power, shape (power - 1, row).

    Args:
        table: Coefficients of powers from the first, dimensionless, shape (power, row).
    """
    return table[1:] * np.arange(2.0, len(table) + 1.0)[:, None]


def new_task(
    network: Network,
    integrator: type[Integrator],
    tolerance: float,
    duration: float,
) -> Task:
    """Return the constant part of the arguments of all calls of a run.

    Args:
        tolerance: Relative error of positions that the scene allows.
        duration: Of the run [s].
    """
    least = min(max(LEDGER_FLOOR, LEDGER_DIGITS / tolerance), FLOOR)
    extent = network.extent
    # Nodes that all coincide in the drawing have no size; the springs may define one.
    size = extent or float(network.springs.rest.max(initial=0.0))
    coordinates = float(np.abs(network.position).max(initial=0.0))
    floor = max(FLOOR * size, TINIEST)
    rounding = min(max(FLOOR * tolerance, LEAST_ROUNDING), ROUNDING)
    # Bristles of faces are cut at the end of each step, which corrects them.
    is_cut = network.contact is not None and network.contact.between is not None
    return Task(
        until=0.0,
        evaluations=0,
        hold=0,
        spacing=0.0,
        viewed=inf,
        fixed=0,
        longest=inf,
        budget=_budget(network, integrator, tolerance, duration),
        growth=GROWTH * integrator.safety * tolerance if integrator.implicit else 0.0,
        share=integrator.share * tolerance,
        latitude=integrator.latitude,
        amplification=integrator.amplification,
        duration=duration,
        rubs=int(integrator.share * tolerance < FINE and not is_cut),
        inside=INSIDE * tolerance,
        jolt=JOLT * tolerance if integrator.promises else inf,
        floor=floor,
        noise=max(rounding * max(coordinates, size), TINIEST),
        least=max(_least_energy(network, least * size, duration), TINIEST),
        bound=1e6 * size if size and network.entity_count else inf,
        stride=inf if network.contact is None else network.contact.stride,
    )


def _budget(
    network: Network, integrator: type[Integrator], tolerance: float, duration: float
) -> float:
    """Return how much error estimates may add up to in a time [1/s]; see ``new_task``.

    Errors of fast motions die away where every spring has a dashpot that brakes its ends within
    the run.
    """
    if not duration:
        return inf
    safety, fading = integrator.safety, getattr(integrator, "fading", 1.0)
    if fading != 1.0:
        weakest = float(network.springs.damping.min(initial=inf))
        heaviest = float(network.mass[: network.body_nodes].max(initial=0.0))
        safety *= fading if weakest * duration > heaviest else 1.0
    return safety * tolerance / duration


def _least_energy(network: Network, floor: float, duration: float) -> float:
    """Return the energy of a displacement too small to measure errors by [J]."""
    stored = most_stored(network, floor)
    mass = float(network.mass[: network.body_nodes].sum())
    speed = floor / duration if duration else 0.0
    return max(stored, 0.5 * mass * speed * speed)  # a power beyond all numbers would raise


def most_stored(network: Network, displacement: float) -> float:
    """Return the energy of the stiffest spring if it is stretched by a displacement [J].

    Args:
        displacement: [m].
    """
    return 0.5 * float(network.springs.sudden.max(initial=0.0)) * displacement * displacement


def least_pressure(state: State, floor: float) -> float:
    """Return the energy of enclosed volumes by a displacement too small to measure by [J]."""
    strain = 3.0 * floor / (state.network.extent or 1.0)
    parts = (part.modulus * float(part.drawn.sum()) for part in state.kept_volumes)
    return 0.5 * sum(parts) * strain * strain


def first_step(inputs: KernelInputs, integrator: type[Integrator], duration: float) -> float:
    """Return a cautious first step, a part of the shortest period of a node [s].

    Gershgorin's bound on a node: ω² ≤ 2 Σ c / m and λ ≤ 2 Σ d / m over its springs.

    Args:
        inputs: The network as the engine keeps it.
        duration: Of the run [s].
    """
    springs, nodes = inputs.springs, len(inputs.layout.order)
    stiff, viscous = springs.stiffness, springs.damping
    if not inputs.features.straight:
        stiff, viscous = _slopes(inputs)
    giving = 0.0
    if springs.inelastic is not None:
        giving = float(springs.inelastic.fastest(stiff).max(initial=0.0))
        stiff = stiff + springs.inelastic.sudden
    rates: list[float] = []
    for constant in (stiff, viscous):
        low, high = springs.ends.T
        total = np.bincount(low, constant, nodes) + np.bincount(high, constant, nodes)
        rates.append(2.0 * float((total * inputs.inverse_mass).max(initial=0.0)))
    fastest = max(sqrt(rates[0]), rates[1], giving)
    return min(duration, 0.1 / fastest) if fastest else 1e-3 * duration


def _slopes(inputs: KernelInputs) -> tuple[Floats, Floats]:
    """Return how stiff [N/m] and how viscous [N s/m] springs are now, shape (spring,)."""
    springs, state = inputs.springs, inputs.state
    behaviour, ends = springs.behaviour, inputs.layout.order[springs.ends].astype(np.int32)
    length, closing = measured(ends, state.position, state.velocity)
    assert closing is not None, "there are velocities"
    elongation = length - springs.rest
    return behaviour.steepness(elongation, closing), behaviour.sluggishness(elongation, closing)


class SampleBuffer:
    """Holds samples until there are enough to hand over.

    Args:
        times: When to record [s], ascending without repetitions, shape (sample,).
        inputs: How the stepping code keeps nodes.
        record: Takes the batches, in the order of the network.
    """

    def __init__(self, times: Floats, inputs: KernelInputs, record: Callable[[Samples], None]):
        self.buffer = new_buffer(times, len(inputs.layout.order), inputs.spring_count)
        self._inputs, self._record = inputs, record
        self._aside: list[Samples] = []

    def make_room(self, steps: int) -> None:
        """Allocate room for states within some steps."""
        buffer = self.buffer
        if buffer.glance_time.size < GLANCES * steps:
            self.buffer = buffer._replace(**glances(steps, buffer.position.shape[1]))

    def set_aside(self, progress: Progress) -> Progress:
        """Keep the samples so far in the order of the network, before places change.

        Call ``fit`` once they have. Returns the updated progress.
        """
        if progress.filled:
            self._aside.append(self._samples(progress.filled))
        return replace(progress, filled=0)

    def fit(self) -> None:
        """Make room for samples of the nodes that have places now."""
        count, size = len(self.buffer.time), 3 * len(self._inputs.layout.order)
        position, velocity = np.zeros((2, count, size))
        rows = {"position": position, "velocity": velocity} | glances(0, size)
        self.buffer = self.buffer._replace(**rows)

    def is_due(self, progress: Progress, until: float) -> bool:
        """Return whether the next sample comes before a time [s]."""
        times = self.buffer.times
        return progress.sample < times.size and bool(times[progress.sample] < until)

    def enter(self, progress: Progress, x: Floats, v: Floats, ledger: Floats) -> Progress:
        """Append the next sample; return the updated progress.

        Args:
            progress: State of the step loop.
            x: Positions [m], flat, shape (3 node,).
            v: Velocities [m/s], flat, shape (3 node,).
            ledger: Work and dissipated energy [J], shape (2,).
        """
        buffer = self.buffer
        if progress.filled == buffer.time.size:
            progress = self.flush(progress)
        index = progress.filled
        buffer.time[index] = buffer.times[progress.sample]
        buffer.position[index], buffer.velocity[index], buffer.ledger[index] = x, v, ledger
        buffer.error[index], buffer.reach[index] = progress.error, progress.displacement
        return replace(progress, sample=progress.sample + 1, filled=index + 1)

    def flush(self, progress: Progress) -> Progress:
        """Hand over the samples so far; return the updated progress."""
        parts = [*self._aside, *([self._samples(progress.filled)] if progress.filled else [])]
        self._aside = []
        if len(parts) == 1:
            self._record(parts[0])
        elif parts:
            columns = map(np.concatenate, zip(*parts, strict=True))
            self._record(Samples(*columns))
        return replace(progress, filled=0)

    def _samples(self, count: int) -> Samples:
        """Return the first samples of the buffer."""
        buffer = self.buffer
        return Samples(
            time=buffer.time[:count].copy(),
            position=self._inputs.positions(buffer.position[:count]),
            velocity=self._inputs.outwards(buffer.velocity[:count]),
            work=buffer.ledger[:count, 0].copy(),
            dissipated=buffer.ledger[:count, 1].copy(),
            error=buffer.error[:count].copy(),
            reach=buffer.reach[:count].copy(),
        )
