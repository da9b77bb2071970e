"""Start, combination and end of prescribed motions.

All orders to one mover make one motion, x(t) = centre + R(t) (base - centre) + Σ vectorᵢ sᵢ(t):
a rigid motion of everything that the mover drives, whatever of it is under way.
"""

from collections.abc import Callable

import numpy as np
from msgspec import Struct

from tissuec.core.arrays import divided
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.forces.acting.load import LoadTerm
from tissuec.mechanics.guiding import DirectedHold
from tissuec.mechanics.state import PrescribedMotion, PrescribedRotation, State
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile
from tissuec.script.verbs import EventQueue, LoggedEvent, Mover
from tissuec.script.verbs.holding import add_to_held, guide, halt, held_by, sentence


class EndMotion(Struct, frozen=True):
    """The end of one order of motion: its nodes rest exactly at its end, still held."""

    mover: str
    stop: float  # [s]
    span: Span

    def apply(self, state: State, queue: EventQueue) -> tuple[LoggedEvent, ...]:
        if self.mover not in state.motions:
            return ()
        settle(state, self.mover, lambda profile: profile.stop <= self.stop, self.stop)
        return (LoggedEvent("end", (), f"end of: {sentence(self.span)}", self.span),)


def driven_by(state: State, mover: Mover) -> Indices:
    """Return the nodes that a mover moves now: its own, or those the tool holds, shape (n,)."""
    return held_by(state, mover.name) if mover.nodes is None else mover.nodes


def set_off(
    state: State,
    mover: Mover,
    span: Span,
    *,
    shifts: tuple[LoadTerm, ...] = (),
    turn: PrescribedRotation | None = None,
    directions: Floats | None = None,
) -> str:
    """Let a mover hold its nodes and follow an additional path whose profiles begin now.

    Args:
        state: Changed in place.
        mover: Set or tool that moves.
        span: The sentence.
        shifts: Displacements times profiles.
        turn: Rotation about its present centre; it replaces a turn that is under way.
        directions: In which nodes are held, unit vectors, shape (direction, 3); None for all.

    Returns:
        The name of the motion in the state.
    """
    nodes, name, change = driven_by(state, mover), mover.name, None
    state.place_held()
    if directions is None:
        add_to_held(state, name, nodes)
        halt(state, nodes, lambda other: other != name)
    else:
        hold = DirectedHold(name, nodes, directions, span)
        guide(state, hold)
        name, change = hold.key, np.zeros((0, 3, 3))
    state.hold_ends.pop(name, None)
    if turn is not None:
        stop_turning(state, mover.name)
    motion = state.motions.get(
        name, PrescribedMotion(nodes[:0], np.zeros((0, 3)), (), None, span, change)
    )
    motion = joined(motion, state, nodes)
    if turn is not None:
        turn = replace(turn, centre=turn.centre - _shift(motion, state.time))
    state.motions[name] = replace(
        motion, shifts=motion.shifts + shifts, turn=turn or motion.turn, span=span
    )
    if directions is not None:
        state.guide()
    state.place_held()
    return name


def joined(motion: PrescribedMotion, state: State, nodes: Indices) -> PrescribedMotion:
    """Return a motion that carries additional nodes along from their present positions.

    Args:
        state: The present state.
        nodes: Indices, shape (n,).
    """
    _, new = divided(nodes, motion.nodes)
    base = state.position[new] - _shift(motion, state.time)
    if motion.turn is not None:
        base = replace(motion.turn, angle=-motion.turn.angle).apply(base, state.time)[0]
    every = np.concatenate([motion.nodes, new])
    order = np.argsort(every)
    return replace(motion, nodes=every[order], base=np.concatenate([motion.base, base])[order])


def settle(
    state: State, mover: str, is_over: Callable[[TimeProfile], bool], time: float
) -> None:
    """End the parts of a motion with selected profiles, at their values at a time.

    Args:
        state: Changed in place.
        mover: Name of the set or tool that moves.
        is_over: Returns whether a profile is selected.
        time: The written time [s], from which the present one may differ by a rounding error.
    """
    motion = state.motions[mover]
    if motion.turn is not None and is_over(motion.turn.profile):
        motion = replace(motion, base=motion.turn.apply(motion.base, time)[0], turn=None)
    over = replace(motion, shifts=tuple(t for t in motion.shifts if is_over(t.profile)))
    gone, kept = _shift(over, time), tuple(t for t in motion.shifts if not is_over(t.profile))
    turn = motion.turn and replace(motion.turn, centre=motion.turn.centre + gone)
    motion = replace(motion, base=motion.base + gone, shifts=kept, turn=turn)
    state.motions[mover] = motion
    state.place_held()
    if not kept and turn is None:
        del state.motions[mover]


def stop_shifting(state: State, mover: str) -> bool:
    """End the translations of a mover where they are; return whether there were any."""
    directed = [name for name, hold in state.directed.items() if hold.holder == mover]
    names = [name for name in (mover, *directed) if name in state.motions]
    names = [name for name in names if state.motions[name].shifts]
    for name in names:
        profiles = [term.profile for term in state.motions[name].shifts]
        settle(state, name, lambda profile, own=profiles: profile in own, state.time)
    return bool(names)


def stop_turning(state: State, mover: str) -> bool:
    """End the turn of a mover where it is; return whether there was one."""
    motion = state.motions.get(mover)
    if motion is None or motion.turn is None:
        return False
    turning = motion.turn.profile
    settle(state, mover, lambda profile: profile is turning, state.time)
    return True


def schedule(
    queue: EventQueue, profiles: tuple[TimeProfile, ...], time: float, duration: float | None
) -> tuple[tuple[TimeProfile, ...], float]:
    """Return profiles that begin at a time, and the time at which all of them end [s].

    Steps end at the knots of the profiles.

    Args:
        queue: Takes the knots.
        profiles: Written to begin at 0 s.
        time: Start of the order [s].
        duration: When the order ends after ``time`` [s]; None: with the longest profile.
    """
    stop = np.inf if duration is None else time + duration
    begun = tuple(profile.begin(time, until=stop) for profile in profiles)
    for profile in begun:
        queue.land(profile.knots)
    return begun, max(profile.stop for profile in begun)


def _shift(motion: PrescribedMotion, time: float) -> Floats:
    """Return how far the translations of a motion have gone [m], shape (3,)."""
    return sum((term.profile.at(time)[0] * term.vector for term in motion.shifts), np.zeros(3))
