"""States within an accepted step: samples, energies, conditions and ruptures.

Called by the loop over steps, ``engine.step``, and bound with it.

Shared arguments:
    time, end: Start and end of the step [s].
    h: Size of the step [s].
    current: Half of ``work`` that contains the start of the step, 0 or 1; the end is in the
        other.
    now: The state of the run, changed in place.
    task: What this call of the loop is to do.
    work: State and scratch of the run; its fields give the shapes and units.
    net: What acts on the nodes; its fields give the shapes and units.
    buffer: Samples that are not handed over yet.
    x: Positions of all nodes [m], flat, shape (3 node,).
    v: Velocities of all nodes [m/s], flat, shape (3 node,).
    ledger: Work and dissipated energy [J], shape (2,).
    when: Time within the step [s].
    pieces: Number of equal parts for the quadrature.
"""

from math import inf, isfinite

from tissuec.engine.integrators.hermite import cubic, quintic
from tissuec.engine.integrators.verlet import VelocityVerlet, book, prepare
from tissuec.engine.step_refined import (
    MOST_HALVINGS,
    lateness,
    mark_doubtful,
    refine,
    refine_ledger,
)
from tissuec.forces.accelerations import force, kinetic, place
from tissuec.forces.springs.springs_kernel import peaks, tension
from tissuec.kernels.records import GLANCES, LOOKED, Buffer, Floats, Net, Progress, Task, Work
from tissuec.kernels.stages import combine
from tissuec.kernels.vectors import (
    accumulate,
    copy_sample,
    polynomials,
    quadrature,
    scale,
)

LOOKS = VelocityVerlet.looks
REFINES = len(VelocityVerlet.embedded_x) > 0
# Rupture is examined closely from this part of the strength on; covers the difference between
# the parabola through three looks and the tension's true profile.
MARGIN = 0.999
# Of Gauss and Legendre on the unit interval.
GAUSS_POINTS = (
    0.06943184420297371,
    0.33000947820757187,
    0.6699905217924281,
    0.9305681557970263,
)
GAUSS_WEIGHTS = (
    0.17392742256872692,
    0.32607257743127307,
    0.32607257743127307,
    0.17392742256872692,
)


def is_due(now: Progress, buffer: Buffer) -> bool:
    """Return whether a sample is due within the step, after its start and before its end."""
    times, sample = buffer.times, now.sample
    while sample < times.size and times[sample] <= now.time:
        sample += 1
    return sample < times.size and times[sample] < now.end


def deliver(now: Progress, task: Task, work: Work, net: Net, buffer: Buffer) -> None:
    """Copy samples from the start of a step up to, but not at, its end, while there is room."""
    time, end, current, first = now.time, now.end, now.current, now.filled
    while now.sample < buffer.times.size and buffer.times[now.sample] < end:
        row = now.filled
        if row == buffer.time.size:
            break
        when = buffer.times[now.sample]
        buffer.time[row], buffer.reach[row] = when, now.displacement_before
        if when <= time:
            x, v = work.x[current], work.v[current]
            copy_sample(x, v, work.ledger[current], now.error, row, buffer)
        else:
            x, v = buffer.position[row], buffer.velocity[row]
            buffer.error[row] = now.error
            look(when, time, end, current, x, v, buffer.ledger[row], work, net)
        now.sample += 1
        now.filled += 1
    is_within = now.filled > first and buffer.time[now.filled - 1] > time
    if REFINES and task.fixed == 0 and is_within:
        doubted = mark_doubtful(first, now, task, work, buffer)
        if doubted or work.pieces[0] > 0:
            refine(first, now, work, buffer, net)


def glance(now: Progress, task: Task, work: Work, net: Net, buffer: Buffer) -> None:
    """Copy states within an accepted step, and at its end, into the buffer.

    Within the step, they are interpolated from both ends without evaluating forces, accurately
    enough to see whether a closer test is needed. With ``task.spacing``, states that are much
    nearer to each other are left out, but for that at which the loop lands.
    """
    time, end, current, looks = now.time, now.end, now.current, GLANCES
    if task.spacing > 0.0:
        is_near = now.glanced > 0 and end - buffer.glance_time[now.glanced - 1] < task.spacing
        if is_near and end < task.until:
            return
        looks = max(1, int(min(1.0 * GLANCES, (end - time) / task.spacing)))
    for look in range(1, looks):
        part, row = look / looks, now.glanced + look - 1
        x, v = buffer.glance_position[row], buffer.glance_velocity[row]
        buffer.glance_time[row] = time + part * (end - time)
        look_within(part, time, end - time, current, x, v, work, net)
    now.glanced += looks
    last = now.glanced - 1
    buffer.glance_time[last] = end
    scale(1.0, work.x[1 - current], buffer.glance_position[last])
    scale(1.0, work.v[1 - current], buffer.glance_velocity[last])


def balance(now: Progress, task: Task, work: Work, net: Net) -> None:
    """Set the ledger at the end of a step, which may be prepared for that."""
    time, end, current = now.time, now.end, now.current
    wrong = book(time, end, current, work, net)
    work.pieces[0] = 0
    energy = max(now.energy, kinetic(work.v[1 - current], net), turnover(current, work))
    may = bearable(end - time, end, energy, task)
    # Fixed steps are as good as their method, where it keeps the ledger at all.
    if not isfinite(wrong) or (task.fixed == 0 and wrong > may):
        if REFINES:
            refine_ledger(now, may, work, net)
        else:
            prepare(time, end, current, work, net)
            integrate_finely(time, end, current, may, work, net)
            now.prepared = 1
    now.energy = energy


def surpasses(time: float, end: float, current: int, work: Work, net: Net) -> bool:
    """Return whether a spring may have exceeded its strength within the prepared step."""
    x, v = work.trial_x, work.trial_v
    for piece in range(LOOKS + 1):
        when = time + (end - time) * piece / LOOKS
        place_within(when, time, end, current, x, v, work, net)
        tension(x, v, work.tension[piece % 3], net)
        if piece >= 2 and peaks(
            work.tension[(piece - 2) % 3],
            work.tension[(piece - 1) % 3],
            work.tension[piece % 3],
            MARGIN,
            net,
        ):
            return True
    return False


def look(
    when: float,
    time: float,
    end: float,
    current: int,
    x: Floats,
    v: Floats,
    ledger: Floats,
    work: Work,
    net: Net,
) -> None:
    """Set state and ledger to those at a time within the prepared step."""
    place_within(when, time, end, current, x, v, work, net)
    if net.ledger:
        if work.pieces[0] > 0:
            integrate(time, when, time, end, work.pieces[0], current, ledger, work, net)
        else:
            h = end - time
            quadrature(work.ledger[current], h, work.weights[1], work.power, ledger)


def look_within(
    part: float,
    time: float,
    h: float,
    current: int,
    x: Floats,
    v: Floats,
    work: Work,
    net: Net,
) -> None:
    """Set a state to that at a part of a step whose ends are known.

    Args:
        part: Part of the step, 0 to 1.
    """
    other = 1 - current
    from_x, to_x, from_v, to_v, from_a, to_a = quintic(part)
    scale(from_x, work.x[current], x)
    accumulate(to_x, work.x[other], x)
    accumulate(h * from_v, work.v[current], x)
    accumulate(h * to_v, work.v[other], x)
    accumulate(h * h * from_a, work.a[current], x)
    accumulate(h * h * to_a, work.a[other], x)
    from_v, to_v, from_a, to_a = cubic(part)
    scale(from_v, work.v[current], v)
    accumulate(to_v, work.v[other], v)
    accumulate(h * from_a, work.a[current], v)
    accumulate(h * to_a, work.a[other], v)
    place(time + h * part, x, v, net)


def place_within(
    when: float,
    time: float,
    end: float,
    current: int,
    x: Floats,
    v: Floats,
    work: Work,
    net: Net,
) -> None:
    """Set a state to that at a time within the prepared step."""
    h = end - time
    part = (when - time) / h
    polynomials(work.dense_x, part, work.weights[0])
    polynomials(work.dense_v, part, work.weights[1])
    for_x, for_v = work.weights[0], work.weights[1]
    combine(work.x[current], work.v[current], h, for_x, for_v, current, x, v, work)
    place(when, x, v, net)


def turnover(current: int, work: Work) -> float:
    """Return the larger of work done and energy dissipated until the end of a step [J]."""
    return max(abs(work.ledger[1 - current, 0]), abs(work.ledger[1 - current, 1]))


def bearable(h: float, end: float, energy: float, task: Task) -> float:
    """Return the allowed error of work and dissipation of a step [J], as ``judge`` does.

    Where a power jumps, as when a spring turns over at zero length, finer quadrature never
    converges in proportion; hence the floor.

    Args:
        energy: Largest energy so far [J].
    """
    allowed = max(min(task.budget * h, lateness(h, end, task) * task.share), 1e-3 * task.share)
    return allowed * max(energy, task.least) + 2.2e-16 * energy


def integrate_finely(
    time: float, end: float, current: int, may: float, work: Work, net: Net
) -> None:
    """Set the ledger at the end of a prepared step by quadrature on as many pieces as needed.

    Prescribed paths do work even where no free node feels them, so that steps may be too long
    for it. The quadrature never changes the motion.

    Args:
        may: Allowed error [J].
    """
    ledger, finer = work.ledger[1 - current], work.trial_ledger
    left = inf
    for halvings in range(MOST_HALVINGS + 1):
        work.pieces[0] = 1 << halvings
        integrate(time, end, time, end, work.pieces[0], current, finer, work, net)
        left = max(abs(finer[0] - ledger[0]), abs(finer[1] - ledger[1]))
        ledger[0], ledger[1] = finer[0], finer[1]
        if halvings > 0 and left <= may:
            break
    work.doubt[0] += left


def integrate(
    low: float,
    high: float,
    time: float,
    end: float,
    pieces: int,
    current: int,
    ledger: Floats,
    work: Work,
    net: Net,
) -> None:
    """Set a ledger to that at ``high``, by Gauss's rule of four points on equal pieces.

    Args:
        low, high: From the start of the prepared step to a time within it [s].
    """
    x, v, a, power = work.inner[0], work.inner[1], work.inner[2], work.booked[0]
    done = lost = 0.0
    size = (high - low) / pieces
    for piece in range(pieces):
        for point in range(4):
            when = low + size * (piece + GAUSS_POINTS[point])
            place_within(when, time, end, current, x, v, work, net)
            force(when, x, v, a, power, net)
            done += GAUSS_WEIGHTS[point] * power[0]
            lost += GAUSS_WEIGHTS[point] * power[1]
    work.effort[LOOKED] += 4 * pieces
    ledger[0] = work.ledger[current, 0] + size * done
    ledger[1] = work.ledger[current, 1] + size * lost
