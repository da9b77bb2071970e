"""Springs: their length, strain and tension, and how far their rest lengths have flowed."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from tissuec.core import units
from tissuec.forces.springs.springs import flat
from tissuec.mechanics import observables
from tissuec.model.network import Floats, Indices
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.common import ScalarMeasure, one_column
from tissuec.script.measures.points import at_point, at_points
from tissuec.script.measures.snapshot import Snapshot


@MEASURES.member("length")
class Length(ScalarMeasure):
    """The sum of the present lengths of the intact springs of A.

    Of nodes of elements, it is that of the edges between them, such as those along a line.
    """

    form = "length(A)"
    dimension = units.LENGTH
    takes = "springs"
    needs = ("lines",)

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        ends = snapshot.state.network.line_ends[snapshot.intact(subjects[0])]
        total = observables.lengths(ends, snapshot.position).sum(axis=-1)
        return one_column(total, snapshot)


@MEASURES.member("strain")
class Strain(ScalarMeasure):
    """The largest strain |L - L0| / L0 of the intact springs and elements of A.

    That of elements is the largest |λ - 1| of the principal stretches λ of their points, from
    the shape without stress; in walls, of those in the plane. Springs with a rest length L0 of
    0 have no strain and are skipped. If rest lengths flow, L0 is the present one. It is 0 if
    nothing is left.
    """

    form = "strain(A)"
    dimension = units.NUMBER
    takes = "any"
    needs = ("strained",)
    at_points = True

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        if subjects[0].of_points is not None:
            return one_column(at_point(snapshot, subjects[0], _largest_strain), snapshot)
        springs, state = snapshot.intact_springs(subjects[0]), snapshot.state
        rest = observables.rest_lengths(state, snapshot.velocity, springs)
        ends = state.springs.ends[springs]
        stretched = np.abs(observables.elongation(ends, snapshot.position, rest))
        has_length = rest > 0.0
        strain = np.where(has_length, stretched / np.where(has_length, rest, 1.0), 0.0)
        found = strain.max(axis=-1, initial=0.0)
        if not subjects[0].is_springs and state.elements:
            own, _ = at_points(snapshot, snapshot.nodes(subjects[0]), _largest_strain)
            found = np.maximum(found, own.max(axis=-1, initial=0.0))
        return one_column(found, snapshot)


def _largest_strain(elements: Any, position: Floats) -> Floats:
    return np.abs(elements.principal_stretches(position) - 1.0).max(axis=-1)


def _springs(subject: Subject, snapshot: Snapshot) -> Indices:
    """Return the springs of a subject, whether they are there or not, shape (spring,)."""
    return snapshot.state.network.springs_among(subject.lines)


@MEASURES.member("tension")
class Tension:
    """The tension c (L - L0) + d w of every spring of A, 0 once it is cut; the largest counts.

    It is negative in compression and includes relaxing branches. For a thread, it is that of
    its pieces, and of the knot of an open thread once that is tied.
    """

    form = "tension(A)"
    dimension = units.FORCE
    subjects = 1
    takes = "springs"
    needs = ("springs",)

    @staticmethod
    def columns(subjects: Sequence[Subject], snapshot: Snapshot) -> tuple[str, ...]:
        network, springs = snapshot.state.network, _springs(subjects[0], snapshot)
        knots = [thread.hold for thread in network.threads.values() if not thread.closed]
        names = zip(springs, network.springs.ids[springs], strict=True)
        return tuple("knot" if one in knots else f"spring {number}" for one, number in names)

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        springs = _springs(subjects[0], snapshot)
        state = snapshot.position, snapshot.velocity
        tension = observables.tension(snapshot.state, *state, springs)
        for name, thread in snapshot.state.network.threads.items():
            (knot,) = np.nonzero(springs == thread.hold)
            if not len(knot):
                continue
            # While a knot slips, the spring beside it bears what it bears.
            tension[..., knot] += observables.tension(
                snapshot.state, *state, np.array([thread.slip])
            )
            if not thread.closed and name not in snapshot.state.knots:
                tension[..., knot] = np.nan
        return tension

    @staticmethod
    def value(sample: Floats) -> Floats:
        if not sample.shape[-1]:
            return np.zeros(sample.shape[:-1])
        return np.asarray(np.fmax.reduce(sample, axis=-1))


@MEASURES.member("plastic elongation")
class PlasticElongation:
    """The largest plastic change of the rest length of the springs of A.

    It is negative if compression shortened a spring. Cut springs keep their value.
    """

    form = "plastic elongation(A)"
    dimension = units.LENGTH
    subjects = 1
    takes = "springs"
    needs = ("springs", "yielding")
    columns = Tension.columns

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        springs = _springs(subjects[0], snapshot)
        memory = snapshot.state.springs.some(springs).inelastic
        if memory is None:
            return np.zeros((*snapshot.velocity.shape[:-2], len(springs)))
        return memory.flowed(flat(snapshot.velocity))

    @staticmethod
    def value(sample: Floats) -> Floats:
        return sample.max(axis=-1) if sample.shape[-1] else np.zeros(sample.shape[:-1])
