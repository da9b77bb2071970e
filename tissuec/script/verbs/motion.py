"""How prescribed motions begin, join and end.

All orders to one mover make one motion, x(t) = centre + R(t) (base - centre) + Σ vectorᵢ sᵢ(t):
a rigid motion of everything that the mover drives, whatever of it is under way.
"""

from collections.abc import Callable

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from tissuec.core.source import Span
from tissuec.forces.load import Term
from tissuec.mechanics.situation import Motion, Situation, Turn
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import Course
from tissuec.script.verbs import Agenda, Happening, Mover
from tissuec.script.verbs.holding import halt, held_by, sentence


class EndMotion(Struct, frozen=True):
    """The end of one order of motion: what is over rests exactly where it ends, still held."""

    mover: str
    stop: float  # [s]
    span: Span

    def apply(self, situation: Situation, agenda: Agenda) -> tuple[Happening, ...]:
        if self.mover not in situation.motions:
            return ()
        settle(situation, self.mover, lambda course: course.stop <= self.stop, self.stop)
        return (Happening("end", (), f"end of: {sentence(self.span)}", self.span),)


def driven_by(situation: Situation, mover: Mover) -> Indices:
    """Return what a mover moves now: its nodes, or what the tool holds."""
    return held_by(situation, mover.name) if mover.nodes is None else mover.nodes


def set_off(
    situation: Situation,
    mover: Mover,
    span: Span,
    *,
    shifts: tuple[Term, ...] = (),
    turn: Turn | None = None,
) -> None:
    """Let a mover take what it moves and follow one more path, whose courses begin now.

    Args:
        turn: About its present centre; it replaces a turn that is under way.
    """
    nodes = driven_by(situation, mover)
    situation.place_held()
    situation.holders[mover.name] = np.union1d(held_by(situation, mover.name), nodes)
    situation.hold_ends.pop(mover.name, None)
    halt(situation, nodes, lambda name: name != mover.name)
    if turn is not None:
        stop_turning(situation, mover.name)
    motion = situation.motions.get(
        mover.name, Motion(nodes[:0], np.zeros((0, 3)), (), None, span)
    )
    motion = joined(motion, situation, nodes)
    if turn is not None:
        turn = replace(turn, centre=turn.centre - _shift(motion, situation.time))
    situation.motions[mover.name] = replace(
        motion, shifts=motion.shifts + shifts, turn=turn or motion.turn, span=span
    )
    situation.place_held()


def joined(motion: Motion, situation: Situation, nodes: Indices) -> Motion:
    """Return a motion that carries further nodes along from their present places."""
    new = np.setdiff1d(nodes, motion.nodes)
    base = situation.position[new] - _shift(motion, situation.time)
    if motion.turn is not None:
        base = replace(motion.turn, angle=-motion.turn.angle).apply(base, situation.time)[0]
    every = np.concatenate([motion.nodes, new])
    order = np.argsort(every)
    return replace(motion, nodes=every[order], base=np.concatenate([motion.base, base])[order])


def settle(
    situation: Situation, mover: str, is_over: Callable[[Course], bool], time: float
) -> None:
    """End the parts of a motion whose courses ``is_over`` picks, where they are at ``time``.

    That time is the written one, from which the present one may differ by a rounding error.
    """
    motion = situation.motions[mover]
    if motion.turn is not None and is_over(motion.turn.course):
        motion = replace(motion, base=motion.turn.apply(motion.base, time)[0], turn=None)
    over = replace(motion, shifts=tuple(t for t in motion.shifts if is_over(t.course)))
    gone, kept = _shift(over, time), tuple(t for t in motion.shifts if not is_over(t.course))
    turn = motion.turn and replace(motion.turn, centre=motion.turn.centre + gone)
    motion = replace(motion, base=motion.base + gone, shifts=kept, turn=turn)
    situation.motions[mover] = motion
    situation.place_held()
    if not kept and turn is None:
        del situation.motions[mover]


def stop_shifting(situation: Situation, mover: str) -> bool:
    """End the translations of a mover where they are; return whether there were any."""
    motion = situation.motions.get(mover)
    if motion is None or not motion.shifts:
        return False
    courses = [term.course for term in motion.shifts]
    settle(situation, mover, lambda course: course in courses, situation.time)
    return True


def stop_turning(situation: Situation, mover: str) -> bool:
    """End the turn of a mover where it is; return whether there was one."""
    motion = situation.motions.get(mover)
    if motion is None or motion.turn is None:
        return False
    turning = motion.turn.course
    settle(situation, mover, lambda course: course is turning, situation.time)
    return True


def schedule(
    agenda: Agenda, courses: tuple[Course, ...], time: float, duration: float | None
) -> tuple[tuple[Course, ...], float]:
    """Return courses as they begin at a time, and when all of it is over [s].

    Steps are asked to land on the knots of the courses.

    Args:
        courses: Written to begin at 0 s.
        duration: When the order ends after ``time`` [s]; None: with the longest course.
    """
    stop = np.inf if duration is None else time + duration
    begun = tuple(course.begin(time, until=stop) for course in courses)
    for course in begun:
        agenda.land(course.knots)
    return begun, max(course.stop for course in begun)


def _shift(motion: Motion, time: float) -> Floats:
    """Return how far the translations of a motion have gone [m], shape (3,)."""
    return sum((term.course.at(time)[0] * term.vector for term in motion.shifts), np.zeros(3))
