"""Measures: quantities that can be logged, expected or waited for.

A member is a class that is never instantiated. Its ``sample`` takes a snapshot that may be a
batch of samples, and its docstring is what the reference says about it.
"""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.core.registry import Family
from tissuec.core.units import Dimension
from tissuec.model.network import Floats, Indices
from tissuec.script.measures.snapshot import Snapshot


class Subject(Struct, frozen=True, eq=False):
    """The subject of a measure.

    Attributes:
        name: As written, such as "forceps A".
        nodes: The nodes, shape (node,); None for a tool, which means what it holds then.
        lines: The springs, and edges of elements, of the set of springs or body, shape (line,);
            for a set of nodes those with both ends in it.
        is_springs: True where the author named a set of springs.
        weights: Of a point of a body: the parts that its place has of the nodes of its element,
            which are ``nodes``, shape (node,).
        of_points: And the parts that its numbers have of those at the points of the element,
            shape (point,).
    """

    name: str
    nodes: Indices | None
    lines: Indices
    is_springs: bool = False
    weights: Floats | None = None
    of_points: Floats | None = None


class Measure(Protocol):
    """Interface of members of ``MEASURES``.

    Attributes:
        form: How it is written, such as "distance(A, B)".
        dimension: Of its value.
        subjects: How many subjects it takes.
        takes: "nodes", "springs" or "any": which subjects it can be taken of; or "body" or
            "jaws" where it means something of whole bodies or of forceps with jaws only.

    A measure that has a meaning for some bodies only lists what they need in ``needs``, names
    of ``NEEDS``. Without it, the measure would always be 0, which is reported.

    A number of things has ``counts = True`` besides: it is a condition, true where it is not 0.
    What has a value at a point of a body has ``at_points = True``.
    What is 0 wherever contact is off has ``of_contact = True``, and what can be measured of
    scissors ``feels_blades = True``. What needs the energies of the run has ``needs_ledger =
    True``.
    """

    form: str
    dimension: Dimension
    subjects: int
    takes: str

    @staticmethod
    def columns(subjects: Sequence[Subject], snapshot: Snapshot) -> tuple[str, ...]:
        """Return the column names of the components of ``sample`` in a log."""
        ...

    @staticmethod
    def sample(subjects: Sequence[Subject], snapshot: Snapshot) -> NDArray[np.float64]:
        """Return the components in SI units, shape (…, column), axes as of the snapshot."""
        ...

    @staticmethod
    def value(sample: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the one number that conditions compare, such as the length of a force.

        It has the unit of the measure and the shape (…).

        Args:
            sample: Components in the unit of the measure, shape (…, column).
        """
        ...


MEASURES: Family[type[Measure]] = Family("tissuec.script.measures", "measure")
