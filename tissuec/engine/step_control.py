"""Control of steps: landing, errors, corners of laws, contact, springs that turn over.

Called by the loop over steps, ``engine.step``, and bound with it.

Shared arguments:
    time, end: Start and end of the step [s].
    h: Size of the step [s].
    current: Half of ``work`` that contains the start of the step, 0 or 1; the end is in the
        other.
    reach, pace: Largest displacement [m] and largest speed [m/s] until the end of the step.
    task: What this call of the loop is to do.
    x: Positions of all nodes [m], flat, shape (3 node,).
    work: State and scratch of the run; its fields give the shapes and units.
    net: What acts on the nodes; its fields give the shapes and units.
"""

from math import isfinite, sqrt

from tissuec.engine.integrators.verlet import VelocityVerlet
from tissuec.engine.step_inside import look_within
from tissuec.engine.step_refined import lateness
from tissuec.forces.springs.springs_kernel import bend_of_passed, find_sides
from tissuec.kernels.records import Floats, Net, Progress, Task, Work
from tissuec.kernels.vectors import distance, greater, is_passed

CONTROL_ORDER = VelocityVerlet.control_order
SAFETY = VelocityVerlet.safety
IMPLICIT = VelocityVerlet.implicit
# Part of what a step may be wrong by that is left to solving its equations.
SOLVING = 0.02
FIXED = 1e-11  # the same where steps are fixed, relative to the motion so far
# Of what a step may be wrong by, for one corner: what hundreds of corners do adds up.
CORNER_SHARE = 1e-3
# Of what a step may be wrong by, for velocities where a law of contact changes its formula:
# estimates of high order see too little of that.
BEND_SHARE = 0.1
# Of what a step may be wrong by, for bristles where contacts change: their rates jump there,
# once, so that no step is short enough for an error in proportion to it.
JUMP_SHARE = 0.1
CORNER_LOOKS = 4  # in a step, for corners of laws that are passed


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


def shrunk(ratio: float) -> float:
    """Return the size of the next trial over that of a step with a ``ratio`` of ``judge``."""
    if isfinite(ratio):
        return max(0.1, 0.9 * ratio ** (-1.0 / CONTROL_ORDER))
    return 0.25 if IMPLICIT else 0.1


def aim(h: float, displacement: float, speed: float, task: Task, work: Work) -> None:
    """Set the accuracy to which the equations of a step are solved."""
    allowed = FIXED if task.fixed == 1 else SOLVING * min(task.budget * h, task.share)
    # Speeds by themselves: what is left in motions that nothing brakes would stay there.
    pace = max(speed, task.floor / h)
    work.goal[0] = allowed * max(displacement, task.floor) + SOLVING * task.noise
    work.goal[1] = allowed * pace + SOLVING * task.noise / h


def judge(
    now: Progress,
    off: float,
    off_speed: float,
    off_internal: float,
    reach: float,
    pace: float,
    strict: bool,
    thrown: bool,
    task: Task,
) -> float:
    """Return the error of a step divided by the allowed error: per unit step, worst node.

    The allowed estimates add up to ``budget`` times the duration and ``growth``, relative to
    the largest displacement and speed so far: a displacement that grows may have an error in
    proportion to its growth, because otherwise the short steps of a sudden start would be
    allowed almost no error. The share of a single step is bounded as well: where stability
    limits the steps, an error persists for longer than the step that made it, and motions may
    amplify it in every step that is left. Errors of velocities are mostly those of fast
    motions, which change positions by no more than within the step. Where a spring is near its
    strength, though, dashpots transmit them, and the time of rupture depends on them. Internal
    variables are elongations, whose errors count as those of positions.

    An error of velocity where a contact ends grows into an error of position. Rounding of
    positions causes errors of up to noise / h in velocities if h is as long as stability
    permits. Steps that are shorter because of a contact are allowed no more than the longest
    step so far.

    Args:
        now: The state of the run before the step is accepted.
        off, off_speed, off_internal: Estimated errors as ``estimate`` returns them.
        reach, pace: Largest displacement [m] and speed [m/s] until its end.
        strict: Whether errors of velocities count by themselves.
        thrown: Whether a law of contact changes its formula in the step.
    """
    h = now.end - now.time
    noise = task.noise / h
    rubs = thrown and task.rubs == 1 and off_speed > 0.0
    if thrown:
        off_speed /= BEND_SHARE
        noise = task.noise / max(h, now.largest)
    growth = (reach - now.displacement) / max(reach, task.floor)
    share = lateness(h, now.end, task) * task.share
    allowed = min(task.budget * h + task.growth * growth, share)
    lenient = max(pace, reach / h, task.floor / h)
    fair = max(pace, task.floor / h) if strict else lenient
    position = off / (allowed * max(reach, task.floor) + task.noise)
    velocity = off_speed / (allowed * fair + noise)
    internal = off_internal / (allowed * lenient + task.noise / h)
    if rubs:
        once = max(allowed, JUMP_SHARE * share)
        internal = greater(internal, off_internal / BEND_SHARE / (once * fair + noise))
    return greater(position, greater(velocity, internal))


def strayed(x: Floats, since: Floats, net: Net) -> float:
    """Return the largest displacement of a node [m], without NaN.

    Args:
        since: Positions before [m], shape (3 node,).
    """
    return distance(x, since, net.touches.squares, net.team)


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
