"""A step from its start to its end, and the loop over steps; read from top to bottom.

    predict     the stages of the method set positions and velocities (``step``)
    evaluate    forces at each stage (``forces.accelerations.force``)
    estimate    the error of the step (``estimate``, ``judge``)
    correct     a rejected step is tried again with another size (``retry``)
    accept      what is known of the step, and the size of the next one (``accept``)
    events      ruptures, conditions and looks within the step (``examine``)
    samples     states within the step for who records (``deliver``)

Written once for every integrator and both backends. As written here it runs velocity Verlet;
``engine.backends`` binds the names of integrator and operations to others. It comes back
to Python whenever something needs a decision, and can then continue from there.

Shared arguments:
    h: Size of the step [s].
    now: The state of the run, changed in place.
    task: What this call of the loop is to do.
    work: State and scratch of the run; its fields give the shapes and units.
    net: What acts on the nodes; its fields give the shapes and units.
    buffer: Samples that are not handed over yet.
"""

from math import inf, isfinite, nan

from tissuec.engine.integrators.constant_steps import AFTER_REJECTION
from tissuec.engine.integrators.verlet import (
    VelocityVerlet,
    estimate,
    finish,
    prepare,
    propose,
    step,
)
from tissuec.engine.step_control import (
    aim,
    corner,
    jolt,
    judge,
    landing,
    shrunk,
    strayed,
)
from tissuec.engine.step_inside import balance, deliver, glance, is_due, surpasses
from tissuec.forces.accelerations import force, place
from tissuec.forces.contact.bristle_kernel import cut_bristles
from tissuec.forces.springs.springs_kernel import slack
from tissuec.kernels.records import (
    FULL,
    GLANCES,
    HELD,
    LOOKED,
    OUTSIZE,
    PAUSED,
    REACHED,
    ROAMED,
    STRAYED,
    SURPASSED,
    UNDERFLOW,
    UNSOLVED,
    VIEWED,
    Buffer,
    Net,
    Progress,
    Task,
    Trial,
    Work,
)
from tissuec.kernels.vectors import distance, greater, length

SAFETY = VelocityVerlet.safety
IMPLICIT = VelocityVerlet.implicit
NO_REASON = -1  # to come back to Python
# Times the way of a node in a step: stages may be as far beside it.
ASIDE = 4.0
# Parts of a step: above the first, the next one may be as long; up to the second, it is made
# shorter at once.
KEPT, LESS = 0.95, 0.8
# Verdicts about a trial, besides the reasons to come back.
ACCEPTED, REJECTED = -1, -2


def drive(now: Progress, task: Task, work: Work, net: Net, buffer: Buffer) -> int:
    """Step until a decision is needed; return the reason."""
    if now.fresh == 1:
        begin(now, work, net)
    while True:
        if now.pending == 0:
            # Stop where the caller requested it, or where samples are to be taken.
            reason = hindrance(now, task, work, buffer)
            if reason != NO_REASON:
                return reason
            # Predict, evaluate, estimate and correct, until a step is accepted.
            trial = make_step(now, task, work, net)
            if trial.verdict != ACCEPTED:
                return trial.verdict
            # Events: what breaks or becomes true within the step ends the loop.
            reason = examine(now, trial.near, task, work, net, buffer)
            if reason != NO_REASON:
                return reason
        # Samples: up to, but not at, the end of the step.
        deliver(now, task, work, net, buffer)
        if now.sample < buffer.times.size and buffer.times[now.sample] < now.end:
            return FULL
        # The end of this step is the start of the next.
        if net.ledger:
            work.power[1, 0] = work.power[work.end_row, 0]
            work.power[1, 1] = work.power[work.end_row, 1]
        now.time, now.current, now.pending = now.end, 1 - now.current, 0


def begin(now: Progress, work: Work, net: Net) -> None:
    """Find the forces at the beginning."""
    x, v, a = work.x[now.current], work.v[now.current], work.a[now.current]
    place(now.time, x, v, net)
    force(now.time, x, v, a, work.power[1], net)
    work.effort[0] += 1
    if net.ledger:
        work.trend[0] = work.trend[1] = nan
    if net.touched:
        cut_bristles(v, a, net.touches)
        now.bends = net.touches.bends[0]
    now.fresh = 0


def hindrance(now: Progress, task: Task, work: Work, buffer: Buffer) -> int:
    """Return why no further step is to be made, if there is a reason."""
    if now.time >= task.until:
        return REACHED
    if 2 * now.filled >= buffer.time.size:
        # Emptied between steps, where a run can be resumed, rather than within one.
        return FULL
    if now.leeway < 0.0:
        return ROAMED
    return PAUSED if work.effort[0] >= task.evaluations else NO_REASON


def make_step(now: Progress, task: Task, work: Work, net: Net) -> Trial:
    """Try steps until one is accepted, or none can be; return the last trial."""
    is_first = True
    while True:
        now.end = landing(now.time, now.step, task)
        h = now.end - now.time
        if now.end < task.until and h <= 16.0 * 2.2e-16 * abs(now.time) + 1e-300:
            return Trial(UNDERFLOW, False, 0.0, 0.0, 0.0, 0.0)
        evaluated = work.effort[0]
        trial = attempt(now, task, work, net)
        if trial.verdict == STRAYED:
            # Methods must not be chosen by how far lists reach.
            work.effort[LOOKED] += work.effort[0] - evaluated
            work.effort[0] = evaluated
        if trial.verdict == ACCEPTED:
            accept(now, trial, is_first, task, net)
            if now.leeway < inf:
                roam(h, now, work)
            if net.touched:
                cut_bristles(work.v[1 - now.current], work.a[1 - now.current], net.touches)
            if IMPLICIT and task.fixed == 0 and work.solver.made[4] == 1.0:
                now.step = steadied(now.step, h)
        if trial.verdict != REJECTED:
            return trial
        now.rejected += 1
        is_first = False


def attempt(now: Progress, task: Task, work: Work, net: Net) -> Trial:
    """Make one step; where it is rejected, set the size of the next trial."""
    h, current = now.end - now.time, now.current
    x, v = work.x[1 - current], work.v[1 - current]
    if IMPLICIT:
        aim(h, now.displacement, now.speed, task, work)
    if net.touched:
        net.touches.bends[1] = net.touches.bends[2] = now.bends
    # Predict and evaluate: all stages of the method, with the forces at each.
    near = step(now.time, now.end, current, work, net)
    # Contact: what went too far may have passed a shape, or met one that is not listed.
    if net.touched:
        verdict = keep_in_lists(now, task, work, net)
        if verdict != ACCEPTED:
            return Trial(verdict, near, 0.0, 0.0, 0.0, 0.0)
    # Estimate: the error, relative to the largest displacement and speed so far.
    reach = greater(now.displacement, distance(x, work.origin, work.each, work.team))
    pace = greater(now.speed, length(v, work.moving, work.team))
    ratio = 0.0
    off, off_speed, off_internal = estimate(h, current, work)
    # Correct: a step with too large an error is tried again with a smaller size.
    if task.fixed == 0:
        thrown = net.touched and net.touches.bends[1] < net.touches.bends[2]
        # Implicit steps may brake what is too fast for them, and lose its energy.
        strict = near or IMPLICIT or thrown
        ratio = judge(now, off, off_speed, off_internal, reach, pace, strict, thrown, task)
        if not ratio <= 1.0:
            retry(now, h * shrunk(ratio))
            return Trial(REJECTED, near, ratio, off, reach, pace)
    # Accept, unless the result is not finite or too large, or a law has a corner on the way.
    verdict = ACCEPTED
    if IMPLICIT and not isfinite(off):
        verdict = UNSOLVED
    elif not (reach <= task.bound and isfinite(pace + off + off_internal)):
        verdict = OUTSIZE
    else:
        near |= finish(now.time, now.end, current, work, net)
        if turns_over(now, pace, task, work, net) or passes_corner(
            now, reach, pace, task, work, net
        ):
            verdict = REJECTED
    return Trial(verdict, near, ratio, off, reach, pace)


def retry(now: Progress, size: float) -> None:
    """Set the size of the next trial [s]; the controller forgets earlier errors."""
    now.step, now.memory, now.wait = size, 0.0, AFTER_REJECTION


def keep_in_lists(now: Progress, task: Task, work: Work, net: Net) -> int:
    """Return the verdict on a step that may leave the lists of what is near in contact.

    What moves far may pass through a shape, or meet one that is not listed.
    """
    x = work.x[1 - now.current]
    way, since = strayed(x, work.x[now.current], net), strayed(x, net.touches.listed, net)
    if task.fixed == 0 and way > task.stride:
        retry(now, (now.end - now.time) * max(0.1, 0.9 * task.stride / way))
        return REJECTED
    if net.touches.reach < task.stride:
        since += ASIDE * way
    return STRAYED if since > net.touches.reach else ACCEPTED


def turns_over(now: Progress, pace: float, task: Task, work: Work, net: Net) -> bool:
    """Return whether a step is too long for a spring that turns over in it.

    Args:
        pace: Largest speed so far [m/s].
    """
    h, current = now.end - now.time, now.current
    now.room -= pace * h
    if now.room < 0.0:
        now.room = slack(work.x[current], work.x[1 - current], net)
    if now.room < 0.0 and task.fixed == 0:
        worse = jolt(h, pace, current, task, work)
        if worse > 1.0:
            now.usual = max(now.step, abs(now.usual))
            now.step, now.room = h * max(0.1, 0.9 / worse), 0.0
            return True
    return False


def passes_corner(
    now: Progress, reach: float, pace: float, task: Task, work: Work, net: Net
) -> bool:
    """Return whether a step has to land on a corner of a law instead.

    Args:
        reach, pace: Largest displacement [m] and speed [m/s] until its end.
    """
    if net.cornered and task.fixed == 0:
        part = corner(now.time, now.end, now.current, reach, pace, task, work, net)
        if part < 1.0:
            now.usual = -max(now.step, abs(now.usual))
            retry(now, (now.end - now.time) * part)
            return True
    return False


def accept(now: Progress, trial: Trial, is_first: bool, task: Task, net: Net) -> None:
    """Count an accepted step, and set the size of the next one.

    Args:
        trial: The step.
        is_first: Whether no other size was tried before.
    """
    h = now.end - now.time
    now.accepted += 1
    if net.touched:
        now.bends = net.touches.bends[0]
    now.error += trial.error / SAFETY
    now.displacement_before, now.displacement = now.displacement, trial.reach
    now.speed_before, now.speed = now.speed, trial.pace
    now.smallest, now.largest = min(now.smallest, h), max(now.largest, h)
    if task.fixed == 0:
        resize(now, h, trial.ratio, is_first)
    now.pending, now.prepared = 1, 0


def roam(h: float, now: Progress, work: Work) -> None:
    """Note how far nodes may have moved beside the common motion of their body."""
    speed = distance(work.v[1 - now.current], work.drift, work.moving, work.team)
    now.leeway -= greater(now.speed_now, speed) * h
    now.speed_now = speed


def resize(now: Progress, h: float, ratio: float, is_first: bool) -> None:
    """Set the size of the next step.

    Args:
        ratio: Error of the step over what is allowed.
        is_first: Whether no other size was tried before.
    """
    size = now.step
    proposal, now.memory, now.wait = propose(h, ratio, now.memory, now.wait)
    if not is_first:
        proposal = min(proposal, h)
    # A step cut short to land says nothing against the size before it.
    size = max(size, proposal) if h < 0.999999 * size else proposal
    if now.room < 0.0 or now.usual < 0.0:
        # Nor does one that was only so small because a spring turned over in it, or
        # because it was to land on a corner of a law.
        size, now.usual = max(size, abs(now.usual)), 0.0
    now.step = size


def steadied(size: float, h: float) -> float:
    """Return the next step of a method whose matrix is expensive to form for another size [s].

    Slightly shorter steps follow in few changes instead of many.

    Args:
        size: That the method proposes [s].
    """
    if size >= h or size < LESS * h:
        return size
    return h if size >= KEPT * h else LESS * h


def examine(now: Progress, near: bool, task: Task, work: Work, net: Net, buffer: Buffer) -> int:
    """Look into an accepted step; return the reason to come back, if there is one.

    Args:
        near: Whether a spring is near its strength.
    """
    if net.ledger:
        balance(now, task, work, net)
    if task.hold > 0:
        glance(now, task, work, net, buffer)
    suspect = net.watched and near
    if now.prepared == 0 and (suspect or is_due(now, buffer)):
        prepare(now.time, now.end, now.current, work, net)
        now.prepared = 1
    if suspect and surpasses(now.time, now.end, now.current, work, net):
        return SURPASSED
    if now.end >= task.viewed:
        return VIEWED
    is_held = task.hold > 0 and now.glanced > GLANCES * (task.hold - 1)
    return HELD if is_held else NO_REASON
