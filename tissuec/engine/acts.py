"""Motions and loads written out as the tables that kernels read."""

from collections.abc import Sequence

import numpy as np

from tissuec.courses import Course
from tissuec.kernels import acts as codes
from tissuec.kernels.records import Acts
from tissuec.network import Floats, Indices
from tissuec.situation import Load, Motion, Term

KIND_CODES = {
    "constant": codes.CONSTANT,
    "ramp": codes.RAMP,
    "smooth": codes.SMOOTH,
    "sine": codes.SINE,
    "table": codes.TABLE,
}


def pack_acts(
    motions: Sequence[Motion], loads: Sequence[Load], place: Indices, window: Floats
) -> Acts:
    """Return motions and loads as tables.

    Args:
        motions, loads: In the order in which they are applied.
        place: Where the engine keeps each node, shape (node,).
        window: Open interval of time in which courses are evaluated [s], shape (2,); shared.
    """
    count = len(motions) + len(loads)
    courses: list[Course] = []
    terms: list[tuple[Term, ...]] = []
    turn_course = np.full(count, -1)
    turn_centre, turn_axis = np.zeros((count, 3)), np.zeros((count, 3))
    turn_angle = np.zeros(count)
    for act, motion in enumerate(motions):
        terms.append(motion.shifts)
        if motion.turn is not None:
            turn_course[act] = len(courses)
            courses.append(motion.turn.course)
            turn_centre[act], turn_axis[act] = motion.turn.centre, motion.turn.axis
            turn_angle[act] = motion.turn.angle
    terms += [load.terms for load in loads]
    flat = [term for group in terms for term in group]
    nodes = [act.nodes for act in (*motions, *loads)]
    base = [motion.base for motion in motions] + [np.zeros((len(load.nodes), 3)) for load in loads]
    term_course = len(courses) + np.arange(len(flat))
    courses += [term.course for term in flat]
    return Acts(
        motions=len(motions),
        window=window,
        first=_offsets([len(group) for group in nodes]),
        nodes=place[np.concatenate([*nodes, np.zeros(0, dtype=np.int64)])],
        base=np.concatenate([*base, np.zeros((0, 3))]),
        term_first=_offsets([len(group) for group in terms]),
        term_vector=np.array([term.vector for term in flat], dtype=float).reshape(-1, 3),
        term_course=term_course,
        turn_course=turn_course,
        turn_centre=turn_centre,
        turn_axis=turn_axis,
        turn_angle=turn_angle,
        course_kind=np.array([KIND_CODES[c.kind] for c in courses], dtype=np.int64),
        course_start=np.array([c.start for c in courses], dtype=float),
        course_stop=np.array([c.stop for c in courses], dtype=float),
        course_frequency=np.array([c.frequency for c in courses], dtype=float),
        knot_first=_offsets([len(c.times) for c in courses]),
        knot_time=np.concatenate([*(c.times for c in courses), np.zeros(0)]),
        knot_value=np.concatenate([*(c.values for c in courses), np.zeros(0)]),
        knot_slope=np.concatenate([*(c.slopes for c in courses), np.zeros(0)]),
    )


def _offsets(sizes: Sequence[int]) -> Indices:
    """Return where each group begins and, last, where all end."""
    return np.concatenate([[0], np.cumsum(np.array(sizes, dtype=np.int64))]).astype(np.int64)


