"""Shorter steps within an accepted step, where it is too long to be seen inside.

The end of a long step may be accurate although fast motions that have died away, or take a
small part in the motion, make its stages and polynomials worthless, and so samples within it,
work and dissipation. These come from shorter steps then; the motion stays as it is. Only of
methods with ``embedded_x``. Called by ``engine.step_inside``, and bound with it.

Shared arguments:
    now: The state of the run, changed in place.
    task: What this call of the loop is to do.
    work: State and scratch of the run; its fields give the shapes and units.
    net: What acts on the nodes; its fields give the shapes and units.
    buffer: Samples that are not handed over yet.
    first: Row of the buffer with the first sample of the step.
"""

from math import exp, inf

from tissuec.engine.integrators.verlet import book, finish, prepare, step
from tissuec.kernels.records import LOOKED, Buffer, Floats, Net, Progress, Task, Work
from tissuec.kernels.stages import combine
from tissuec.kernels.vectors import distance, greater, length, polynomials, scale

MOST_HALVINGS = 6  # of a step whose work and dissipation are computed on equal pieces
LOOKS_INSIDE = (0.25, 0.5, 0.75)  # parts of the step: the difference has zeros elsewhere
# What is doubted of a sample.
NOTHING, VELOCITIES, STATE = 0, 1, 2


def lateness(h: float, end: float, task: Task) -> float:
    """Return how many times its usual error a step may have: late ones do not grow for long.

    Args:
        h, end: Size and end of the step [s].
    """
    left = (task.duration - end) / h
    return max(task.latitude * exp(-task.amplification * left), 1.0)


def mark_doubtful(first: int, now: Progress, task: Task, work: Work, buffer: Buffer) -> bool:
    """Mark samples of a step whose state may be too wrong; return whether there are any."""
    off, off_speed = differences(now, work)
    h, found = now.end - now.time, False
    # Velocities count twice in energies; within usual steps they are more accurate than needed.
    allowed = 0.5 * task.inside * task.latitude / lateness(h, now.end, task)
    for row in range(first, now.filled):
        buffer.doubtful[row] = NOTHING
        if buffer.time[row] > now.time:
            reach = distance(buffer.position[row], work.origin, work.each, work.team)
            pace = length(buffer.velocity[row], work.moving, work.team)
            reach = max(reach, now.displacement_before, task.floor)
            pace = max(pace, now.speed_before, task.floor / h)
            if not off <= task.inside * reach + task.noise:
                buffer.doubtful[row] = STATE
            elif not off_speed <= allowed * pace + task.noise / h:
                buffer.doubtful[row] = VELOCITIES
            found |= buffer.doubtful[row] != NOTHING
    return found


def differences(now: Progress, work: Work) -> tuple[float, float]:
    """Return how far two polynomials differ in positions [m] and velocities [m/s] at most.

    Those of velocities are of a lower order than the ones that are used, and differ the more.
    """
    h, for_x, for_v, zero = now.end - now.time, work.weights[0], work.weights[1], work.zero
    x, v, off, off_speed = work.trial_x, work.trial_v, 0.0, 0.0
    for part in LOOKS_INSIDE:
        polynomials(work.embedded_x, part, for_x)
        polynomials(work.embedded_v, part, for_v)
        combine(zero, zero, h, for_x, for_v, now.current, x, v, work)
        off = greater(off, length(x, work.each, work.team))
        off_speed = greater(off_speed, length(v, work.each, work.team))
    return off, off_speed


def refine(first: int, now: Progress, work: Work, buffer: Buffer, net: Net) -> None:
    """Replace what is doubted of samples, and their ledgers if that of the step was replaced.

    Positions that are good enough stay as they are.
    """
    evaluations, time, middle = work.effort[0], now.time, 0.5 * (now.time + now.end)
    scale(1.0, work.ledger[1 - now.current], work.trial_ledger)
    for row in range(first, now.filled):
        when, doubt, ledger = buffer.time[row], buffer.doubtful[row], buffer.ledger[row]
        if doubt != NOTHING:
            x = buffer.position[row] if doubt == STATE else work.trial_x
            # A step that is nearly as long may be worse inside than the whole one.
            pieces = 1 if when <= middle else 2
            march(when, pieces, now, x, buffer.velocity[row], ledger, work, net)
        if work.pieces[0] > 0 and when > time:
            march(when, work.pieces[0], now, work.trial_x, work.trial_v, ledger, work, net)
    step_again(evaluations, now, work, net)
    prepare(time, now.end, now.current, work, net)


def refine_ledger(now: Progress, may: float, work: Work, net: Net) -> None:
    """Set the ledger at the end of a step to that of as many shorter steps as needed.

    Args:
        may: Allowed error [J].
    """
    evaluations, left = work.effort[0], inf
    x, v, ledger = work.trial_x, work.trial_v, work.trial_ledger
    for halvings in range(1, MOST_HALVINGS + 1):
        work.pieces[0] = 1 << halvings
        left = march(now.end, work.pieces[0], now, x, v, ledger, work, net)
        if left <= may:
            break
    work.doubt[0] += left
    step_again(evaluations, now, work, net)


def march(
    when: float,
    pieces: int,
    now: Progress,
    x: Floats,
    v: Floats,
    ledger: Floats,
    work: Work,
    net: Net,
) -> float:
    """Set a state and a ledger by equal steps from the start of the step; its end is lost.

    Args:
        when: Time in the step that they belong to [s].
        pieces: Number of steps.
        x, v: Positions [m] and velocities [m/s], shape (3 node,).
        ledger: Work and dissipated energy [J], shape (2,).

    Returns:
        Estimated error of the ledger [J].
    """
    half, size, wrong = now.current, (when - now.time) / pieces, 0.0
    done, lost = work.ledger[half, 0], work.ledger[half, 1]
    working, losing = work.power[1, 0], work.power[1, 1]
    scale(1.0, work.x[half], work.inner[0])
    scale(1.0, work.v[half], work.inner[1])
    scale(1.0, work.a[half], work.inner[2])
    end = now.time
    for piece in range(pieces):
        start, end = end, when if piece + 1 == pieces else now.time + size * (piece + 1)
        if end > start:  # rounding may leave nothing of a short one
            step(start, end, half, work, net)
            finish(start, end, half, work, net)
            if net.ledger:
                wrong += book(start, end, half, work, net)
                scale(1.0, work.power[work.end_row], work.power[1])
            half = 1 - half
    scale(1.0, work.x[half], x)
    scale(1.0, work.v[half], v)
    scale(1.0, work.ledger[half], ledger)
    half = now.current
    scale(1.0, work.inner[0], work.x[half])
    scale(1.0, work.inner[1], work.v[half])
    scale(1.0, work.inner[2], work.a[half])
    work.ledger[half, 0], work.ledger[half, 1] = done, lost
    work.power[1, 0], work.power[1, 1] = working, losing
    return wrong


def step_again(evaluations: int, now: Progress, work: Work, net: Net) -> None:
    """Make the whole step again, and set its ledger to ``work.trial_ledger``.

    Args:
        evaluations: Those before shorter steps were made; the others count as looks inside.
    """
    step(now.time, now.end, now.current, work, net)
    finish(now.time, now.end, now.current, work, net)
    scale(1.0, work.trial_ledger, work.ledger[1 - now.current])
    work.effort[LOOKED] += work.effort[0] - evaluations
    work.effort[0] = evaluations
