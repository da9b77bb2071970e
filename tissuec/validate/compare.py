"""Quantities and events of a run compared with those of the reference.

Shared arguments:
    run: The engine's run.
    reference: The reference solution.
    network: The network.
    bound: Allowed error, dimensionless; None if there is none.
    tolerance: Tolerance of the run, dimensionless; None if it has none.
    valid: Rows that can be compared, shape (row,).
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core import units
from tissuec.core.units import Dimension
from tissuec.mechanics.state import State
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.measures import MEASURES
from tissuec.script.plan import Plan
from tissuec.script.verbs.holding import FIX
from tissuec.validate.engine_run import Observed
from tissuec.validate.solution import Break, Reference, TriggerFiring
from tissuec.validate.uncertainty import floor_of, relative, relative_positions

FLOOR = 1e-6  # of the largest energy of the run: below, rounding and errors look alike


class QuantityError(Struct, frozen=True):
    """The largest error of something.

    Attributes:
        name: Such as "position" or "force of forceps A".
        error: Relative to ``scale``.
        bound: What was promised; None where nothing was.
        expected: Error that positions just within the promise can cause; None if unknown.
        scale: What the error is relative to, where it is largest; see ``dimension_of``.
        time: When the error is largest [s].
        node: Where; None where it is not of one node.
    """

    name: str
    error: float
    bound: float | None
    expected: float | None
    scale: float
    time: float
    node: int | None = None

    @property
    def is_kept(self) -> bool | None:
        """Return whether the promise is kept; None where there is none."""
        return None if self.bound is None else self.error <= self.bound


def dimension_of(name: str) -> Dimension:
    """Return the dimension of the scale of a quantity by its name."""
    if name.startswith(FORCE_OF):
        return units.FORCE
    return _DIMENSIONS[name.partition(",")[0]]


FORCE_OF = "force of "
_DIMENSIONS = {
    "position": units.LENGTH,
    "energy balance": units.ENERGY,
    "velocity": units.VELOCITY,
}


def position_errors(run: Observed, reference: Reference, network: Network) -> Floats:
    """Return the largest relative error of a position at each time, dimensionless.

    The shape is (row,).
    """
    error = _distance(run.position, reference.position).max(axis=1, initial=0.0)
    return relative_positions(error, reference.displacement, network)


def position(
    run: Observed, reference: Reference, network: Network, bound: float | None, rows: int
) -> list[QuantityError]:
    """Return the error of positions, relative to the largest displacement so far.

    Args:
        rows: Number of rows with a limit; the error of all rows is added if there are more.
    """
    errors = position_errors(run, reference, network)
    found: list[QuantityError] = []
    if rows:
        found.append(_worst_position("position", run, reference, network, bound, errors[:rows]))
    if rows < len(errors):
        name = "position, whole run"
        found.append(_worst_position(name, run, reference, network, None, errors))
    return found


def _worst_position(
    name: str,
    run: Observed,
    reference: Reference,
    network: Network,
    bound: float | None,
    errors: Floats,
) -> QuantityError:
    row = int(np.argmax(errors))
    node = int(np.argmax(_distance(run.position[row], reference.position[row])))
    scale = max(float(reference.displacement[row]), floor_of(network))
    time = float(reference.times[row])
    return QuantityError(name, float(errors[row]), bound, None, scale, time, node)


def velocity(run: Observed, reference: Reference, valid: NDArray[np.bool_]) -> QuantityError:
    """Return the error of velocities, relative to the largest speed of the run."""
    error = _distance(run.velocity, reference.velocity) * valid[:, None]
    scale = float(reference.speed[-1])
    row, node = np.unravel_index(np.argmax(error), error.shape)
    worst = relative(error[row, node], np.array(scale), 0.0)
    time = float(reference.times[row])
    return QuantityError("velocity", float(worst), None, None, scale, time, int(node))


def support_forces(
    run: Observed,
    reference: Reference,
    state: State,
    groups: Mapping[str, tuple[Indices, ...]],
    valid: NDArray[np.bool_],
    tolerance: float | None,
) -> list[QuantityError]:
    """Return the errors of the forces on groups, each relative to its largest force.

    A force is c times a difference of positions, so that an error of positions by the tolerance
    times the displacement changes a force by Σ c over the springs of the group times that,
    which is given as ``expected``. The force on a tool that touches nothing follows from its
    own path and jet; it is compared with the tolerance.

    Args:
        state: Present spring constants.
        groups: The nodes of each group at each row.
    """
    found: list[QuantityError] = []
    for name, members in groups.items():
        own = np.array([-f[n].sum(axis=0) for f, n in zip(run.force, members, strict=True)])
        true = np.array(
            [-f[n].sum(axis=0) for f, n in zip(reference.force, members, strict=True)]
        )
        scale = float(np.linalg.norm(true, axis=1).max())
        error = np.linalg.norm(own - true, axis=1) * valid
        row = int(np.argmax(error))
        bound = expected = None
        if _is_free_tool(state, members):
            bound = tolerance
        elif tolerance is not None and scale > 0.0 and not _touches(state, members):
            reach = max(_stiffness(state, nodes) for nodes in _distinct(members))
            expected = tolerance * float(reference.displacement[-1]) * reach / scale
        worst = float(relative(error[row], np.array(scale), 0.0))
        time = float(reference.times[row])
        found.append(QuantityError(f"{FORCE_OF}{name}", worst, bound, expected, scale, time))
    return found


def energy_balance(run: Observed, network: Network, bound: float | None) -> QuantityError:
    """Return the energy that a run cannot account for, relative to the largest so far.

    Energies below that of the smallest displacement with a limit do not count.
    """
    of_elements = (each.stiffest for each in network.elements)
    stiffest = max(float(network.springs.sudden.max(initial=0.0)), *of_elements, 0.0)
    stored = 0.5 * stiffest * floor_of(network) ** 2
    floor = max(FLOOR * float(run.scale[-1]), stored)
    errors = relative(np.abs(run.imbalance), run.scale, floor)
    row = int(np.argmax(errors))
    scale, time = max(float(run.scale[row]), floor), float(run.times[row])
    return QuantityError("energy balance", float(errors[row]), bound, None, scale, time)


def force_groups(plan: Plan, reference: Reference) -> dict[str, tuple[Indices, ...]]:
    """Return the nodes on which forces are compared, by name, shape (n,) for each row.

    These are the held nodes, by holder, and the sets of force logs.
    """
    groups: dict[str, tuple[Indices, ...]] = {}
    nothing = np.zeros(0, dtype=np.int64)
    for name in dict.fromkeys(name for holders in reference.holders for name in holders):
        label = "fixed nodes" if name == FIX else name
        groups[label] = tuple(holders.get(name, nothing) for holders in reference.holders)
    for log in plan.output.logs:
        subject = log.subjects[0] if log.measure is MEASURES["force"] else None
        if subject is not None and subject.nodes is not None:
            groups[subject.name] = (subject.nodes,) * len(reference.times)
    return groups


def _distance(first: Floats, second: Floats) -> Floats:
    """Return distances of points, shape (…,)."""
    return np.linalg.norm(first - second, axis=-1)


def _distinct(members: tuple[Indices, ...]) -> list[Indices]:
    return list({nodes.tobytes(): nodes for nodes in members}.values())


def _touches(state: State, members: tuple[Indices, ...]) -> bool:
    """Return whether some nodes carry a tool, whose contacts then decide its force."""
    bodies = state.network.body_nodes
    return any((nodes >= bodies).any() for nodes in _distinct(members))


def _is_free_tool(state: State, members: tuple[Indices, ...]) -> bool:
    """Return whether all nodes are those of tools, in a scene without contact."""
    bodies = state.network.body_nodes
    alone = all((nodes >= bodies).all() for nodes in _distinct(members))
    return state.touching is None and alone and any(map(len, members))


def _stiffness(state: State, nodes: Indices) -> float:
    """Return Σ c over the springs with one end among some nodes [N/m]."""
    inside = np.zeros(state.network.node_count, dtype=bool)
    inside[nodes] = True
    first, second = inside[state.springs.ends].T
    stiffness = state.springs.stiffness
    if state.springs.inelastic is not None:
        stiffness = stiffness + state.springs.inelastic.sudden
    return float(stiffness[first != second].sum())


TIE = 1e-9  # of the duration: events closer than this have no order


class Miss(Struct, frozen=True):
    """An event of one solution only.

    Attributes:
        number: Of the spring or trigger.
        time: When it happened [s].
        in_run: Whether in the run rather than in the reference.
        strain: Of a spring, how near the other solution came to breaking it: largest tension
            or pressure over the force that breaks; of a trigger 0.
        is_tie: Whether an error of positions as large as the promise can explain it.
    """

    number: int
    time: float
    in_run: bool
    strain: float = 0.0
    is_tie: bool = False


class Matching(Struct, frozen=True):
    """Comparison of the events of a run with those of the reference.

    Attributes:
        run, reference: How many events there were.
        error: Largest difference between times of the same event [s]; 0 without any.
        worst: The spring or trigger of that event; None without any.
        in_order: Whether the events of both came in the same order.
        misses: What happened in one of them only, ascending in time.
    """

    run: int
    reference: int
    error: float
    worst: int | None
    in_order: bool
    misses: tuple[Miss, ...]


Times = dict[int, float]


def break_times(breaks: Sequence[Break]) -> Times:
    """Return when each spring broke [s]."""
    return {int(spring): entry.time for entry in breaks for spring in entry.springs}


def firing_times(firings: Sequence[TriggerFiring]) -> Times:
    """Return when each trigger fired [s]."""
    return {firing.trigger: firing.time for firing in firings}


def match(run: Times, reference: Times, misses: Sequence[Miss], duration: float) -> Matching:
    """Return how times of events in a run match those of the reference.

    Args:
        run: Times of events in the run [s].
        reference: Times of events in the reference [s].
        misses: Events of only one of them.
        duration: Of the run [s].
    """
    both = sorted(run.keys() & reference.keys(), key=lambda key: (reference[key], run[key]))
    errors = {key: abs(run[key] - reference[key]) for key in both}
    worst = max(errors, key=lambda key: errors[key], default=None)
    apart = TIE * duration
    in_order = all(
        run[before] <= run[after] + apart or reference[after] - reference[before] <= apart
        for before, after in pairwise(both)
    )
    error = errors[worst] if worst is not None else 0.0
    found = tuple(sorted(misses, key=lambda miss: miss.time))
    return Matching(len(run), len(reference), error, worst, in_order and not found, found)


def missed(run: Times, reference: Times) -> list[Miss]:
    """Return the events of one solution that are missing in the other."""
    only_run = [Miss(key, run[key], True) for key in run.keys() - reference.keys()]
    only_reference = [Miss(key, reference[key], False) for key in reference.keys() - run.keys()]
    return only_run + only_reference


def near_ties(
    misses: Sequence[Miss],
    network: Network,
    strains: tuple[Floats, Floats],
    shift: float,
) -> list[Miss]:
    """Return missed breaks with the distance of the other solution from breaking.

    Args:
        misses: Breaks in only one solution.
        strains: Largest tension or pressure divided by its limit, of each spring in the run and
            in the reference, shape (spring,) each.
        shift: Allowed error of positions [m]; two ends give twice the change of length.
    """
    run, reference = strains
    found: list[Miss] = []
    for miss in misses:
        spring = miss.number
        strain = float((reference if miss.in_run else run)[spring])
        limit = min(network.springs.strength[spring], network.springs.crush[spring])
        allowed = 2.0 * network.springs.sudden[spring] * shift / limit
        tie = abs(1.0 - strain) <= allowed
        found.append(Miss(spring, miss.time, miss.in_run, strain, bool(tie)))
    return found


def between_events(
    rows: Floats, run: Times, reference: Times, duration: float
) -> NDArray[np.bool_]:
    """Return at which times an event has happened in only one solution, shape (row,).

    Forces and velocities jump at events, so that they cannot be compared there.

    Args:
        rows: Times [s], shape (row,).
        run: Times of events in the run [s].
        reference: Times of events in the reference [s].
        duration: Of the run [s].
    """
    apart = np.zeros(len(rows), dtype=bool)
    for key in run.keys() & reference.keys():
        low, high = sorted((run[key], reference[key]))
        apart |= (rows >= low - TIE * duration) & (rows <= high + TIE * duration)
    return apart
