"""Motions and loads as the tables that kernels read, for one interval of time."""

from collections.abc import Iterable, Sequence
from math import inf

import numpy as np

from tissuec.forces.load import Load, LoadTerm
from tissuec.kernels.records import BoundaryConditions
from tissuec.mechanics.state import PrescribedMotion, State
from tissuec.model.network import Floats, Indices
from tissuec.model.profiles import TimeProfile, tabulated

LOOKS = 32  # samples at least of a period of a path or force, or of a full turn, or of a ramp


def lengths(state: State) -> list[Load]:
    """Return how lengths of threads change, as loads on no node, to be evaluated as these."""
    along, none = np.array([1.0, 0.0, 0.0]), np.zeros(0, dtype=np.int64)
    return [
        Load(none, (LoadTerm(along, reeling.profile),), reeling.span)
        for reeling in state.reelings.values()
    ]


def knots(motions: Iterable[PrescribedMotion], profiles: Iterable[TimeProfile]) -> Floats:
    """Return the times at which a profile changes its curve [s], ascending, shape (knot,).

    Args:
        motions: Prescribed motions.
        profiles: All profiles except those of motions.
    """
    found = [*profiles, *(term.profile for motion in motions for term in motion.shifts)]
    found += [motion.turn.profile for motion in motions if motion.turn is not None]
    return np.array(sorted({knot for profile in found for knot in profile.knots.tolist()}))


def longest_step(
    motions: Iterable[PrescribedMotion],
    profiles: Iterable[TimeProfile],
    start: float,
    until: float,
    looks: int,
) -> float:
    """Return the largest step that follows prescribed motions in an interval of time [s].

    No error estimate sees a path that no free node feels; springs between driven and held nodes
    would break unnoticed, or in another period. Nor does one see a force that is sampled once
    in each of its periods.

    Args:
        motions: All of them.
        profiles: Of all else.
        start, until: The stretch, without knots inside [s].
        looks: How often a step is looked into.
    """
    middle = start + 0.5 * (until - start)
    longest = inf
    for profile in profiles:
        longest = min(longest, _feature(profile, middle))
    for motion in motions:
        for term in motion.shifts:
            longest = min(longest, _feature(term.profile, middle))
        turn = motion.turn
        if turn is not None:
            longest = min(longest, _feature(turn.profile, middle))
            if turn.angle and (fastest := _fastest(turn.profile, start, until)) > 0.0:
                longest = min(longest, 2.0 * np.pi / (fastest * abs(turn.angle)))
    return float(longest) * looks / LOOKS


def _feature(profile: TimeProfile, time: float) -> float:
    """Return the length of the shortest feature of a profile at a time [s]."""
    if profile.start < time < profile.stop:
        if profile.kind == "sine" and profile.frequency:
            return 1.0 / abs(profile.frequency)
        if profile.kind in ("ramp", "smooth"):
            return profile.stop - profile.start
    return inf


def _fastest(profile: TimeProfile, start: float, until: float) -> float:
    """Return about the largest rate of a profile within a stretch [1/s]."""
    if profile.kind == "sine":
        return 2.0 * np.pi * abs(profile.frequency)
    inside = start + (until - start) * np.linspace(0.0, 1.0, LOOKS + 1)[1:-1]
    return max(abs(profile.at(float(time))[1]) for time in inside)


def pack_acts(
    motions: Sequence[PrescribedMotion],
    loads: Sequence[Load],
    place: Indices,
    start: float,
    until: float,
) -> BoundaryConditions:
    """Return motions and loads as tables for a stretch of time without knots inside.

    A velocity that jumps at an end of the stretch is the one within the stretch.

    Args:
        motions, loads: In the order in which they are applied.
        place: Where the engine keeps each node, shape (node,).
        start, until: The stretch [s].
    """
    count = len(motions) + len(loads)
    profiles: list[TimeProfile] = []
    terms: list[tuple[LoadTerm, ...]] = []
    turn_curve = np.full(count, -1)
    turn_centre, turn_axis = np.zeros((count, 3)), np.zeros((count, 3))
    turn_angle = np.zeros(count)
    for act, motion in enumerate(motions):
        terms.append(motion.shifts)
        if motion.turn is not None:
            turn_curve[act] = len(profiles)
            profiles.append(motion.turn.profile)
            turn_centre[act], turn_axis[act] = motion.turn.centre, motion.turn.axis
            turn_angle[act] = motion.turn.angle
    terms += [load.terms for load in loads]
    flat = [term for group in terms for term in group]
    nodes = [act.nodes for act in (*motions, *loads)]
    base = [motion.base for motion in motions] + [
        np.zeros((len(load.nodes), 3)) for load in loads
    ]
    term_curve = len(profiles) + np.arange(len(flat))
    return BoundaryConditions(
        motions=len(motions),
        first=_offsets([len(group) for group in nodes]),
        nodes=place[np.concatenate([*nodes, np.zeros(0, dtype=np.int64)])],
        base=np.concatenate([*base, np.zeros((0, 3))]),
        term_first=_offsets([len(group) for group in terms]),
        term_vector=np.array([term.vector for term in flat], dtype=float).reshape(-1, 3),
        term_curve=term_curve,
        turn_curve=turn_curve,
        turn_centre=turn_centre,
        turn_axis=turn_axis,
        turn_angle=turn_angle,
        **tabulated([*profiles, *(term.profile for term in flat)], start, until),
    )


def _offsets(sizes: Sequence[int]) -> Indices:
    """Return where each group begins and, last, where all end."""
    return np.concatenate([[0], np.cumsum(np.array(sizes, dtype=np.int64))]).astype(np.int64)
