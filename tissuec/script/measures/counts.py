"""Numbers of things: nodes, springs and elements that are left, pieces, ruptures."""

from collections.abc import Sequence

import numpy as np

from tissuec.core import units
from tissuec.core.arrays import distinct
from tissuec.model.network import Floats
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.common import ScalarMeasure, one_column
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("nodes")
class Nodes(ScalarMeasure):
    """The number of nodes of a set or body, or of those that a tool holds."""

    form = "count(nodes of A)"
    dimension = units.NUMBER
    counts = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return one_column(len(snapshot.nodes(subjects[0])), snapshot)


@MEASURES.member("springs")
class IntactSprings(ScalarMeasure):
    """The number of springs of A that are neither cut nor ruptured."""

    form = "count(springs of A)"
    dimension = units.NUMBER
    takes = "any"
    counts = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        return one_column(len(snapshot.intact(subjects[0])), snapshot)


@MEASURES.member("elements")
class IntactElements(ScalarMeasure):
    """The number of finite elements that have lost no edge to a cut and have not broken.

    All nodes of an element belong to A.
    """

    form = "count(elements of A)"
    dimension = units.NUMBER
    needs = ("elements",)
    counts = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        state, count = snapshot.state, 0
        inside = np.zeros(state.network.node_count, dtype=bool)
        inside[snapshot.nodes(subjects[0])] = True
        for field in state.elements:
            own = np.array(inside[field.nodes].all(axis=1))
            own[field.lost_items(state.alive)] = False
            count += int(own.sum())
        return one_column(count, snapshot)


@MEASURES.member("pieces")
class Pieces(ScalarMeasure):
    """The number of connected pieces of the net that contain nodes of A.

    Two nodes are in one piece if a chain of intact springs, inside A or not, connects them.
    Springs of joints do not count: two sutured pieces are two pieces.
    """

    form = "count(pieces of A)"
    dimension = units.NUMBER
    counts = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        found = snapshot.pieces[snapshot.nodes(subjects[0])]
        return one_column(len(distinct(found)), snapshot)


@MEASURES.member("ruptured")
class Ruptured(ScalarMeasure):
    """The number of springs of A that have broken by themselves; true if it is not 0.

    They are torn by tension or crushed by compression; the event log distinguishes both. In
    bodies that are made of elements, it is the number of elements all of whose nodes belong to
    A.
    """

    form = "ruptured(A)"
    dimension = units.NUMBER
    takes = "any"
    counts = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        subject, network = subjects[0], snapshot.state.network
        entities = snapshot.lines(subject)
        if not subject.is_springs and network.element_count:
            springs = network.springs_among(entities)
            entities = np.append(springs, snapshot.elements(subject))
        return one_column(np.count_nonzero(snapshot.ruptured[entities]), snapshot)
