"""The loop over steps: step size control, landing, samples, and detection of ruptures.

Written once for every integrator and both backends. As written here it runs velocity Verlet;
``engine.backends`` binds the names of integrator and operations to others. It comes back
to Python whenever something needs a decision, and can then go on where it was.

Shared arguments:
    time, end: Start and end of the step [s].
    h: Size of the step [s].
    current: Half of ``work`` that contains the start of the step, 0 or 1; the end is in the
        other.
    task: What this call of the loop is to do.
    work: State and scratch of the run; its fields give the shapes and units.
    net: What acts on the nodes; its fields give the shapes and units.
    buffer: Samples that are not handed over yet.
    x: Positions of all nodes [m], flat, shape (3 node,).
    v: Velocities of all nodes [m/s], flat, shape (3 node,).
    ledger: Work and dissipated energy [J], shape (2,).
    displacement, reach: Largest displacement so far [m].
    speed, pace: Largest speed so far [m/s].
    when: Time within the step [s].
    pieces: Number of equal parts for the quadrature.
"""

from math import inf, isfinite, nan, sqrt

from tissuec.engine.integrators.hermite import cubic, quintic
from tissuec.engine.integrators.verlet import (
    VelocityVerlet,
    book,
    estimate,
    finish,
    prepare,
    propose,
    step,
)
from tissuec.forces.accelerations import force, kinetic, place
from tissuec.forces.springs_kernel import bend_of_passed, find_sides, peaks, slack, tension
from tissuec.kernels.records import (
    FULL,
    GLANCES,
    HELD,
    LOOKED,
    OUTSIZE,
    PAUSED,
    REACHED,
    STRAYED,
    SURPASSED,
    UNDERFLOW,
    UNSOLVED,
    VIEWED,
    Buffer,
    Floats,
    Net,
    Progress,
    Task,
    Work,
)
from tissuec.kernels.vectors import (
    accumulate,
    combine,
    copy_sample,
    distance,
    is_passed,
    polynomials,
    quadrature,
    scale,
)

END_ROW = VelocityVerlet.end_row
LOOKS = VelocityVerlet.looks
CONTROL_ORDER = VelocityVerlet.control_order
SAFETY = VelocityVerlet.safety
IMPLICIT = VelocityVerlet.implicit
# Part of what a step may be wrong by that is left to solving its equations.
SOLVING = 0.02
FIXED = 1e-11  # the same where steps are fixed, relative to the motion so far
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
# Of what a step may be wrong by, for one corner: what hundreds of corners do adds up.
CORNER_SHARE = 1e-3
# The same of velocities, where contacts begin or end: their law bends there without a corner.
BEND_SHARE = 0.1
CORNER_LOOKS = 4  # in a step, for corners of laws that are passed
MOST_HALVINGS = 6  # of a step whose powers are looked at on equal pieces


def drive(
    now: Progress, task: Task, work: Work, net: Net, buffer: Buffer
) -> tuple[int, Progress]:
    """Step until a decision is needed; return the reason and the progress.

    Args:
        now: Progress at the start of this call.
    """
    time, size, end, memory, calm = now.time, now.step, now.end, now.memory, now.calm
    displacement, speed, room, usual = now.displacement, now.speed, now.room, now.usual
    current, pending, prepared, fresh = now.current, now.pending, now.prepared, now.fresh
    accepted, rejected, sample, filled = now.accepted, now.rejected, now.sample, now.filled
    smallest, largest, energy, error = now.smallest, now.largest, now.energy, now.error
    bends, glanced = now.bends, now.glanced
    if fresh:
        bends = begin(time, current, bends, work, net)
        fresh = 0
    growing = True
    reason = REACHED
    while True:
        if pending == 0:
            if time >= task.until:
                reason = REACHED
                break
            # Not while a step is tried again: what was learned from it would be forgotten.
            if growing and 2 * filled >= buffer.time.size:
                # Emptied between steps, where a run can be resumed, rather than within one.
                reason = FULL
                break
            if growing and work.effort[0] >= task.evaluations:
                reason = PAUSED
                break
            end = landing(time, size, task)
            h = end - time
            if end < task.until and h <= 16.0 * 2.2e-16 * abs(time) + 1e-300:
                reason = UNDERFLOW
                break
            if IMPLICIT:
                aim(h, displacement, speed, task, work)
            if net.touched:
                net.touches.bends[1] = net.touches.bends[2] = bends
            near = step(time, end, current, work, net)
            if net.touched:
                # What moves far may pass through a shape, or meet one that is not listed.
                way = strayed(work.x[1 - current], work.x[current], net)
                if task.fixed == 0 and way > 1.0:
                    size = h * max(0.1, 0.9 / way)
                    rejected += 1
                    memory, calm, growing = 0.0, 0, False
                    continue
                if strayed(work.x[1 - current], net.touches.listed, net) > 1.0:
                    reason = STRAYED
                    break
            x, v = work.x[1 - current], work.v[1 - current]
            reach = greater(displacement, distance(x, work.origin, work.each, work.team))
            pace = greater(speed, distance(v, work.zero, work.moving, work.team))
            ratio = 0.0
            off, off_speed = estimate(h, current, work)
            if task.fixed == 0:
                # What is thrown off flies on as wrongly as it was thrown.
                thrown = net.touched and net.touches.bends[1] < net.touches.bends[2]
                if thrown:
                    off_speed /= BEND_SHARE
                # Implicit steps may brake what is too fast for them, and lose its energy.
                strict, growth = near or IMPLICIT or thrown, reach - displacement
                ratio = judge(h, off, off_speed, reach, pace, growth, strict, task)
                if not ratio <= 1.0:
                    size = h * shrunk(ratio)
                    rejected += 1
                    memory, calm, growing = 0.0, 0, False
                    continue
            if IMPLICIT and not isfinite(off):
                reason = UNSOLVED
                break
            if not (reach <= task.bound and isfinite(pace + off)):
                reason = OUTSIZE
                break
            near |= finish(time, end, current, work, net)
            room -= pace * h
            if room < 0.0:
                room = slack(work.x[current], work.x[1 - current], net)
                if room < 0.0 and task.fixed == 0:
                    worse = jolt(h, pace, current, task, work)
                    if worse > 1.0:
                        usual = max(size, abs(usual))
                        size, room = h * max(0.1, 0.9 / worse), 0.0
                        rejected += 1
                        growing = False
                        continue
            if net.cornered and task.fixed == 0:
                part = corner(time, end, current, reach, pace, task, work, net)
                if part < 1.0:
                    usual = -max(size, abs(usual))
                    size = h * part
                    rejected += 1
                    memory, calm, growing = 0.0, 0, False
                    continue
            accepted += 1
            if net.touched:
                bends = net.touches.bends[0]
            error += off / SAFETY
            displacement, speed = reach, pace
            smallest, largest = min(smallest, h), max(largest, h)
            if task.fixed == 0:
                proposal, memory, calm = propose(h, ratio, memory, calm)
                if not growing:
                    proposal = min(proposal, h)
                # A step cut short to land says nothing against the size before it.
                size = max(size, proposal) if h < 0.999999 * size else proposal
                if room < 0.0 or usual < 0.0:
                    # Nor does one that was only so small because a spring turned over in it, or
                    # because it was to land on a corner of a law.
                    size, usual = max(size, abs(usual)), 0.0
                growing = True
            pending, prepared = 1, 0
            if net.ledger:
                energy, prepared = balance(time, end, current, energy, task, work, net)
            if task.hold > 0:
                glance(time, end, current, glanced, work, net, buffer)
                glanced += GLANCES
            suspect = net.watched and near
            if prepared == 0 and (suspect or is_due(sample, time, end, buffer)):
                prepare(time, end, current, work, net)
                prepared = 1
            if suspect and surpasses(time, end, current, work, net):
                reason = SURPASSED
                break
            if end >= task.viewed:
                reason = VIEWED
                break
            if task.hold > 0 and glanced >= GLANCES * task.hold:
                reason = HELD
                break
        sample, filled = deliver(
            sample, filled, time, end, current, error, work, net, buffer,
        )  # fmt: skip
        if sample < buffer.times.size and buffer.times[sample] < end:
            reason = FULL
            break
        if net.ledger:
            work.power[1, 0] = work.power[END_ROW, 0]
            work.power[1, 1] = work.power[END_ROW, 1]
        time, current, pending = end, 1 - current, 0
    return reason, Progress(
        time=time,
        step=size,
        end=end,
        memory=memory,
        calm=calm,
        displacement=displacement,
        speed=speed,
        current=current,
        pending=pending,
        prepared=prepared,
        fresh=fresh,
        accepted=accepted,
        rejected=rejected,
        sample=sample,
        filled=filled,
        smallest=smallest,
        largest=largest,
        energy=energy,
        error=error,
        room=room,
        usual=usual,
        bends=bends,
        glanced=glanced,
    )


def begin(time: float, current: int, bends: int, work: Work, net: Net) -> int:
    """Find the forces at the beginning; return how often contact has begun or ended until then.

    Args:
        bends: The number of bends of the law of contact that were passed before.
    """
    place(time, work.x[current], work.v[current], net)
    x, v, a = work.x[current], work.v[current], work.a[current]
    force(time, x, v, a, work.power[1], net)
    work.effort[0] += 1
    if net.ledger:
        work.trend[0] = work.trend[1] = nan
    return net.touches.bends[0] if net.touched else bends


def shrunk(ratio: float) -> float:
    """Return the size of the next trial over that of a step with a ``ratio`` of ``judge``."""
    if isfinite(ratio):
        return max(0.1, 0.9 * ratio ** (-1.0 / CONTROL_ORDER))
    return 0.25 if IMPLICIT else 0.1


def balance(
    time: float, end: float, current: int, energy: float, task: Task, work: Work, net: Net
) -> tuple[float, int]:
    """Set the ledger at the end of a step.

    Returns:
        The largest energy so far [J], and whether the step was prepared for looks inside.
    """
    wrong = book(time, end, current, work, net)
    work.pieces[0] = 0
    energy = max(energy, kinetic(work.v[1 - current], net), turnover(current, work))
    may = bearable(end - time, energy, task)
    # Fixed steps are as good as their method, where it keeps the ledger at all.
    if not isfinite(wrong) or (task.fixed == 0 and wrong > may):
        prepare(time, end, current, work, net)
        integrate_finely(time, end, current, may, work, net)
        return energy, 1
    return energy, 0


def deliver(
    sample: int,
    filled: int,
    time: float,
    end: float,
    current: int,
    error: float,
    work: Work,
    net: Net,
    buffer: Buffer,
) -> tuple[int, int]:
    """Copy samples from the start of a step up to, but not at, its end, while there is room.

    Args:
        sample: Index of the next sample.
        filled: Rows of the buffer that are filled.
        error: Estimated error of positions [m].

    Returns:
        The number of the next sample, and how many rows of the buffer are filled.
    """
    while sample < buffer.times.size and buffer.times[sample] < end:
        if filled == buffer.time.size:
            break
        when = buffer.times[sample]
        buffer.time[filled] = when
        if when <= time:
            x, v = work.x[current], work.v[current]
            copy_sample(x, v, work.ledger[current], error, filled, buffer)
        else:
            x, v = buffer.position[filled], buffer.velocity[filled]
            buffer.error[filled] = error
            look(when, time, end, current, x, v, buffer.ledger[filled], work, net)
        sample += 1
        filled += 1
    return sample, filled


def strayed(x: Floats, since: Floats, net: Net) -> float:
    """Return the largest displacement of a node divided by the allowed one, without NaN.

    Args:
        since: Positions at which pairs of contact were listed [m], shape (3 node,).
    """
    return distance(x, since, net.touches.squares, net.team) / net.touches.stride


def landing(time: float, size: float, task: Task) -> float:
    """Return the end of the next step, such that no very short step is left before ``until``.

    Args:
        size: Size of the step that is proposed [s].
    """
    rest = task.until - time
    if task.fixed == 0:
        size = min(size, task.longest)
    if size >= rest * (1.0 - 1e-10):
        return task.until
    if task.fixed == 1:
        # Uniform steps differ from their multiple by rounding only.
        return task.until if rest < 1.5 * size else time + size
    return time + (0.5 * rest if size > 0.5 * rest else size)


def is_due(sample: int, time: float, end: float, buffer: Buffer) -> bool:
    """Return whether a sample is due after ``time`` and before ``end``.

    Args:
        sample: Index of the next sample.
    """
    times = buffer.times
    while sample < times.size and times[sample] <= time:
        sample += 1
    return sample < times.size and times[sample] < end


def aim(h: float, displacement: float, speed: float, task: Task, work: Work) -> None:
    """Set the accuracy to which the equations of a step are solved."""
    allowed = FIXED if task.fixed == 1 else SOLVING * min(task.budget * h, task.share)
    # Speeds by themselves: what is left in motions that nothing brakes would stay there.
    pace = max(speed, task.floor / h)
    work.goal[0] = allowed * max(displacement, task.floor) + SOLVING * task.noise
    work.goal[1] = allowed * pace + SOLVING * task.noise / h


def judge(
    h: float,
    off: float,
    off_speed: float,
    reach: float,
    pace: float,
    growth: float,
    strict: bool,
    task: Task,
) -> float:
    """Return the error of a step divided by the allowed error: per unit step, worst node.

    The allowed estimates add up to ``budget`` times the duration and ``growth``, relative to
    the largest displacement and speed so far: a displacement that grows may have an error in
    proportion to its growth, because otherwise the short steps of a sudden start would be
    allowed almost no error. The share of a single step is bounded as well: where stability
    limits the steps, an error persists for longer than the step that made it. Errors of
    velocities are mostly those of fast motions, which change positions by no more than within
    the step. Where a spring is near its strength, though, dashpots transmit them, and the time
    of rupture depends on them.

    Args:
        h: Size of the step [s].
        off, off_speed: Estimated errors of positions [m] and velocities [m/s].
        reach, pace: Largest displacement [m] and speed [m/s] until its end.
        growth: Of the largest displacement in the step [m].
        strict: Whether errors of velocities count by themselves.
    """
    part = growth / max(reach, task.floor)
    allowed = min(task.budget * h + task.growth * part, task.share)
    fair = pace if strict else max(pace, reach / h)
    position = off / (allowed * max(reach, task.floor) + task.noise)
    velocity = off_speed / (allowed * max(fair, task.floor / h) + task.noise / h)
    return greater(position, velocity)


def jolt(h: float, pace: float, current: int, task: Task, work: Work) -> float:
    """Return the change of velocities by a spring that turns over, divided by the allowed one.

    Its force jumps where its length vanishes, which estimates of errors may miss.
    """
    jump = h * distance(work.a[1 - current], work.a[current], work.each, work.team)
    return jump / (task.jolt * max(pace, task.floor / h) + task.noise / h)


def corner(
    time: float,
    end: float,
    current: int,
    reach: float,
    pace: float,
    task: Task,
    work: Work,
    net: Net,
) -> float:
    """Return the part of a step at which to land on a corner of a law, 1 if there is none.

    A corner that changes the rate of accelerations by b makes errors of b δ²/2 in velocities
    and b δ² h/2 in positions, δ being the time to the nearer end of the step. Where that is
    below the allowed error of a step, no landing is needed.
    """
    h, x, v = end - time, work.inner[0], work.inner[1]
    first, here = work.sides[0], work.sides[1]
    find_sides(time, work.x[current], work.v[current], first, net)
    bend = 0.0
    for look in range(1, CORNER_LOOKS + 1):
        look_within(look / CORNER_LOOKS, time, h, current, x, v, work, net)
        find_sides(time + h * look / CORNER_LOOKS, x, v, here, net)
        if is_passed(first, here):
            from_x, from_v = work.x[current], work.v[current]
            bend = greater(bend, bend_of_passed(from_x, from_v, x, v, h, first, here, net))
    if bend == 0.0:
        return 1.0
    # Nothing is on the safe side here, as estimates of the method are.
    allowed = CORNER_SHARE / SAFETY * min(task.budget * h, task.share)
    place_off = allowed * max(reach, task.floor) + task.noise
    speed_off = allowed * max(pace, task.floor / h) + task.noise / h
    near = sqrt(2.0 * min(speed_off, place_off / h) / bend) / h
    near = max(near, 32.0 * 2.2e-16 * max(abs(end), h) / h)
    if near >= 0.5:
        return 1.0
    return passage(near, time, h, current, work, net)


def passage(near: float, time: float, h: float, current: int, work: Work, net: Net) -> float:
    """Return the part of a step at which the first corner is passed, 1 if there is none.

    Args:
        near: Part of the step at either end in which corners may be passed.
    """
    x, v = work.inner[0], work.inner[1]
    first, here = work.sides[0], work.sides[1]
    look_within(near, time, h, current, x, v, work, net)
    find_sides(time + h * near, x, v, first, net)
    before = after = near
    for look in range(1, CORNER_LOOKS + 1):
        before, after = after, min(max(look / CORNER_LOOKS, near), 1.0 - near)
        look_within(after, time, h, current, x, v, work, net)
        find_sides(time + h * after, x, v, here, net)
        if is_passed(first, here):
            break
    else:
        return 1.0
    # Closer than this is the same to the next step.
    while after - before > 0.25 * near:
        middle = 0.5 * (before + after)
        look_within(middle, time, h, current, x, v, work, net)
        find_sides(time + h * middle, x, v, here, net)
        if is_passed(first, here):
            after = middle
        else:
            before = middle
    return after


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


def glance(
    time: float, end: float, current: int, glanced: int, work: Work, net: Net, buffer: Buffer
) -> None:
    """Copy states within an accepted step, and at its end, into the buffer.

    They are interpolated from both ends of the step without evaluating forces, accurately
    enough to see whether a closer test is needed.

    Args:
        glanced: Row of the buffer for the first of them.
    """
    for look in range(GLANCES):
        part, row = (look + 1) / GLANCES, glanced + look
        buffer.glance_time[row] = end if look + 1 == GLANCES else time + part * (end - time)
        x, v = buffer.glance_position[row], buffer.glance_velocity[row]
        look_within(part, time, end - time, current, x, v, work, net)


def greater(one: float, two: float) -> float:
    """Return the larger of two numbers, and NaN if either is NaN."""
    return max(one, two) + 0.0 * (one + two)


def turnover(current: int, work: Work) -> float:
    """Return the larger of work done and energy dissipated until the end of a step [J]."""
    return max(abs(work.ledger[1 - current, 0]), abs(work.ledger[1 - current, 1]))


def bearable(h: float, energy: float, task: Task) -> float:
    """Return the allowed error of work and dissipation of a step [J], as ``judge`` does.

    Where a power jumps, as when a spring turns over at zero length, finer quadrature never
    converges in proportion; hence the floor.

    Args:
        energy: Largest energy so far [J].
    """
    allowed = max(min(task.budget * h, task.share), 1e-3 * task.share)
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
    combine(
        work.x[current], h * h, for_x, work.v[current], h, for_v, work.rows, x, v, work.team
    )
    place(when, x, v, net)


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
