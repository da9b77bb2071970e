"""Steps by a tableau with their derivatives: forwards, backwards, with many changes at once.

Free nodes move as ``Tableau`` says; driven ones continue from where they are by what is
prescribed, and others stay. Backwards, derivatives by the result become derivatives by the
stages before it, from the last one to the first. (W. W. Hager, Numer. Math. 87:247, 2000, for
the adjoint of Runge-Kutta methods.)

Shared arguments:
    i: Index of the stage.
    row: Index of the step, which begins at this row of the trail.
    forces: Everything that accelerations follow from, beside the state.
    steps: The steps and what is prescribed during them.
    start: State at the beginning of the step.
    known: Accelerations of stages [m/s²], or changes of them, shape (stage, 3 node).
    to: State that is set.
    trail: States at the ends of steps, shape (row, 3 node).
    stages: Room for the states of stages, shape (stage, 3 node).
    entering: Derivatives that enter in each row, shape (row, 3 node).
    dues: Derivatives by the stages, shape (stage, 3 node).
    due: Derivatives by a state.
    seeds: Changes of the numbers of springs and nodes.
"""

from typing import NamedTuple

from tissuec.forces.accelerations_derivatives_kernel import (
    acceleration,
    pull_back,
    push_forward,
)
from tissuec.kernels.derivative_records import Forces, NodeState, NodeStates, Seeds, Values
from tissuec.kernels.records import Floats, Integers, Rows, Tableau
from tissuec.kernels.thread_loops import PIECE
from tissuec.kernels.vectors import accumulate, scale


class Steps(NamedTuple):
    """Consecutive steps of a method, and prescribed motions and loads at moments of each.

    Attributes:
        times: Of the rows of a trail, which steps lead from one to the next of [s].
        place, speed: Of driven nodes [m], [m/s], shape (moment, 3 driven).
        load: Changing forces [N], shape (moment, 3 loaded).
        moments: How many of them a step has; the first one is its beginning.
        moment: Of each stage, from that of the beginning on, shape (stage,).
    """

    tableau: Tableau
    times: Floats
    place: Rows
    speed: Rows
    load: Rows
    moments: int
    moment: Integers


def length_of(row: int, steps: Steps) -> float:
    """Return the size of a step [s]."""
    return steps.times[row + 1] - steps.times[row]


def time_of(i: int, row: int, steps: Steps) -> float:
    """Return the time of a stage [s]."""
    return steps.times[row] + length_of(row, steps) * steps.tableau.for_x[i, 0]


def state(row: int, states: NodeStates) -> NodeState:
    """Return one of many states."""
    return NodeState(states.x[row], states.v[row], states.a[row])


def moment_of(i: int, row: int, steps: Steps) -> int:
    """Return the index of the moment of a stage in ``steps.place`` and ``steps.load``."""
    return row * steps.moments + steps.moment[i]


def combine_stage(
    i: int, row: int, forces: Forces, steps: Steps, start: NodeState, known: Rows, to: NodeState
) -> None:
    """Set positions and velocities of a stage, or many changes of them, from previous stages.

    Args:
        row: Number of the step, which begins at ``start``.
        known: Accelerations of stages, or changes of them, shape (stage, 3 node).
    """
    table, inverse, h = steps.tableau, forces.links.inverse, length_of(row, steps)
    # Blocks that stay in the cache while all rows are added to them.
    for first in range(0, to.x.size, PIECE):
        part = slice(first, min(first + PIECE, to.x.size))
        x, v, x0, v0, c = (
            to.x[part],
            to.v[part],
            start.x[part],
            start.v[part],
            table.for_x[i, 0],
        )
        for k in range(x.size):
            x[k], v[k] = x0[k] + h * c * v0[k], v0[k]
        for j in range(i):
            of_x, of_v = h * h * table.for_x[i, j + 1], h * table.for_v[i, j + 1]
            if of_x != 0.0 or of_v != 0.0:
                a = known[j, part]
                for k in range(x.size):
                    x[k] += of_x * a[k]
                    v[k] += of_v * a[k]
    width = to.x.size // inverse.size
    for node in range(inverse.size):
        if inverse[node] == 0.0:
            for k in range(width * node, width * (node + 1)):
                to.x[k], to.v[k] = start.x[k], 0.0


def enter_stage(
    i: int, row: int, forces: Forces, steps: Steps, start: NodeState, known: Rows, to: NodeState
) -> None:
    """Set positions and velocities of a stage; those of driven nodes are prescribed."""
    combine_stage(i, row, forces, steps, start, known, to)
    driven, now, begun = forces.links.driven, moment_of(i, row, steps), row * steps.moments
    for d in range(driven.size):
        for axis in range(3):
            k, m = 3 * driven[d] + axis, 3 * d + axis
            to.x[k] += steps.place[now, m] - steps.place[begun, m]
            to.v[k] = steps.speed[now, m]


def find_stages(
    row: int, again: bool, forces: Forces, steps: Steps, trail: NodeStates, stages: NodeStates
) -> None:
    """Set all stages before the result.

    Args:
        row: Row of the trail at which the step begins.
        again: Whether the next row of the trail is known, too.
    """
    table, start = steps.tableau, state(row, trail)
    for i in range(table.result):
        at = state(i, stages)
        if table.carries and i == 0:
            scale(1.0, start.a, at.a)
            continue
        enter_stage(i, row, forces, steps, start, stages.a, at)
        if table.carries and again and i == table.result - 1:
            scale(1.0, trail.a[row + 1], at.a)
        else:
            load = steps.load[moment_of(i, row, steps)]
            acceleration(forces, time_of(i, row, steps), load, at)


def step_forward(forces: Forces, steps: Steps, trail: NodeStates, stages: NodeStates) -> None:
    """Fill the rows of a trail after the first one.

    Args:
        trail: Shape (row, 3 node); accelerations in rows are those that steps begin with, if
            the method carries them on.
        stages: Scratch.
    """
    table = steps.tableau
    for row in range(steps.times.size - 1):
        find_stages(row, False, forces, steps, trail, stages)
        start, end = state(row, trail), state(row + 1, trail)
        enter_stage(table.result, row, forces, steps, start, stages.a, end)
        if table.carries:
            scale(1.0, stages.a[table.result - 1], end.a)


def step_back(
    forces: Forces,
    steps: Steps,
    trail: NodeStates,
    entering: NodeStates,
    stages: NodeStates,
    dues: NodeStates,
    due: NodeState,
    by: Values,
) -> None:
    """Carry derivatives by the last row of a trail back to its first row.

    Args:
        entering: Derivatives that enter in each row, shape (row, 3 node); those of the first
            row are left to the caller.
        stages, dues: Scratch for stages and the derivatives by them, shape (stage, 3 node).
        due: By the state of the last row, then of the first one.
        by: Derivatives by numbers, which are added to.
    """
    table = steps.tableau
    for row in range(steps.times.size - 2, -1, -1):
        find_stages(row, True, forces, steps, trail, stages)
        begin_dues(forces, due, state(row + 1, entering), dues)
        for i in range(table.result - 1, -1, -1):
            weigh_stage(i, row, steps, dues)
            if table.carries and i == table.result - 1:
                accumulate(1.0, due.a, dues.a[i])
            if table.carries and i == 0:
                scale(1.0, dues.a[0], due.a)
            else:
                time = time_of(i, row, steps)
                pull_back(forces, time, state(i, stages), state(i, dues), by)
        leave_step(row, forces, steps, dues, due)


def begin_dues(forces: Forces, due: NodeState, entering: NodeState, dues: NodeStates) -> None:
    """Set the derivatives by the result of a step.

    Args:
        entering: Derivatives that enter at the end of the step.
    """
    last = dues.x.shape[0] - 1
    x, v = dues.x[last], dues.v[last]
    for k in range(x.size):
        x[k], v[k] = due.x[k] + entering.x[k], due.v[k] + entering.v[k]
    hold(forces, v)


def weigh_stage(i: int, row: int, steps: Steps, dues: NodeStates) -> None:
    """Set the derivatives by the acceleration of a stage, and clear those by its state."""
    table, h = steps.tableau, length_of(row, steps)
    x, v, a = dues.x[i], dues.v[i], dues.a[i]
    for k in range(a.size):
        x[k], v[k], a[k] = 0.0, 0.0, 0.0
    for j in range(i + 1, dues.x.shape[0]):
        of_x, of_v = h * h * table.for_x[j, i + 1], h * table.for_v[j, i + 1]
        if of_x != 0.0 or of_v != 0.0:
            x, v = dues.x[j], dues.v[j]
            for k in range(a.size):
                a[k] += of_x * x[k] + of_v * v[k]


def leave_step(
    row: int, forces: Forces, steps: Steps, dues: NodeStates, due: NodeState
) -> None:
    """Set the derivatives by the beginning of a step from those by its stages."""
    h = length_of(row, steps)
    for k in range(due.x.size):
        due.x[k], due.v[k] = 0.0, 0.0
    for i in range(dues.x.shape[0]):
        later, x, v = h * steps.tableau.for_x[i, 0], dues.x[i], dues.v[i]
        for k in range(x.size):
            due.x[k] += x[k]
            due.v[k] += v[k] + later * x[k]
    hold(forces, due.v)


def hold(forces: Forces, v: Floats) -> None:
    """Set the derivatives by velocities of held nodes to 0, because these are prescribed.

    Args:
        v: Derivatives in any unit, shape (3 node,).
    """
    inverse = forces.links.inverse
    for node in range(inverse.size):
        if inverse[node] == 0.0:
            for k in range(3 * node, 3 * node + 3):
                v[k] = 0.0


def step_change(
    first: int,
    last: int,
    forces: Forces,
    steps: Steps,
    trail: NodeStates,
    stages: NodeStates,
    seeds: Seeds,
    change: NodeState,
    moved: NodeState,
    known: Rows,
) -> None:
    """Carry many changes of the state over the steps from one row of a trail to a later one.

    Args:
        first, last: The rows.
        stages: Scratch.
        change: Of the state, set again; see ``push_forward``.
        moved, known: Scratch for changes of one stage, and of the accelerations of all stages.
    """
    table, here, there = steps.tableau, change, moved
    scale(1.0, change.a, known[0])
    for row in range(first, last):
        find_stages(row, True, forces, steps, trail, stages)
        for i in range(1 if table.carries else 0, table.result):
            combine_stage(i, row, forces, steps, here, known, there)
            then = NodeState(there.x, there.v, known[i])
            push_forward(forces, time_of(i, row, steps), state(i, stages), seeds, then)
        combine_stage(table.result, row, forces, steps, here, known, there)
        if table.carries:
            scale(1.0, known[table.result - 1], known[0])
        here, there = there, here
    scale(1.0, here.x, change.x)
    scale(1.0, here.v, change.v)
    scale(1.0, known[0], change.a)
