"""The request of a ``learn`` block: measured data, fits, and parameters.

Names are bound to the arrays of the network and numbers are in SI units, as in a plan. Data is
not read here.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Literal

import numpy as np
from msgspec import Struct

from tissuec.core.source import Span
from tissuec.core.units import Dimension
from tissuec.model.network import Floats, Indices
from tissuec.script.measures import Measure, Subject
from tissuec.script.measures.common import DirectedMeasure

POSITIONS = "positions"
"""What is fitted to the places of every node of a set, each for itself."""

# What may be learnt beside quantities of tissues and constants of laws.
REST_LENGTH = "rest length"
START_POSITION = "start position"
START_VELOCITY = "start velocity"
WORDS = "words"
WEIGHTS = "weights"

Per = Literal["tissue", "force", "region", "spring", "node", "set", "word"]


class DataColumn(Struct, frozen=True, eq=False):
    """A column of tables of data: ``column "x_px" in 0.2 mm``.

    Attributes:
        name: As it is called.
        unit: What one in the column is in SI units, 0.0002.
        span: Where it is named.
        factor: The number before the unit, 0.2; 1 without one.
    """

    name: str
    unit: float
    span: Span
    factor: float = 1.0


class Fit(Struct, frozen=True, eq=False):
    """One thing that was measured: ``fit = force(pressed) using column "force_N" in N``.

    Attributes:
        text: As written: "force(pressed)".
        measure: What is measured; None for the positions of every node.
        subjects: What it is measured of; of positions, the nodes.
        along: Unit vector along which a part is taken, shape (3,); None for the whole size
            (of a position: for all three components).
        dimension: Of its value.
        columns: Of tables: one, or x, y and z, or node, x, y and z; empty where only results
            of runs are read, which know what is what.
        every: Time between the values that are used [s]; None: all of them.
        noise: Standard deviation of its values, in SI units; None: taken from what is left.
        weight: Further factor of its part of the error.
        free_zero: Whether an unknown constant was added to its values.
        span: The entry.
    """

    text: str
    measure: type[Measure] | None
    subjects: tuple[Subject, ...]
    along: Floats | None
    dimension: Dimension
    columns: tuple[DataColumn, ...]
    every: float | None
    noise: float | None
    weight: float
    free_zero: bool
    span: Span

    def part(self, components: Floats) -> Floats:
        """Return the part of components along the direction, if there is one.

        Args:
            components: In SI units, shape (…, component).

        Returns:
            Shape (…) with a direction, otherwise (…, component).
        """
        if self.along is None:
            return components
        if self.measure is None:
            return np.asarray(components @ self.along)
        assert issubclass(self.measure, DirectedMeasure)
        return self.measure.along(components, self.along)


class Adjust(Struct, frozen=True, eq=False):
    """An adjusted quantity: ``adjust spring constant of fat from 1 N/m to 1 kN/m``.

    Attributes:
        what: A quantity of tissues such as "spring constant", a constant of its law such as
            "stiffening", an entry of a force such as "stiffness", or ``REST_LENGTH``,
            ``START_POSITION``, ``START_VELOCITY``, ``WORDS``.
        of: Whose: the name of a tissue, force, region, set or body; of ``WORDS``, that of a
            property or quantity of the vocabulary.
        per: What gets a number of its own. "tissue" or "force": that one. "region": each part
            of a body.
            "spring" or "node": each of the set or body. "set": all of them share one factor.
            "word": each word of a scale.
        members: Springs or nodes that are meant, ascending; otherwise empty.
        along: Of positions and velocities: the unit vector along which; None for all axes.
        dimension: Of its value.
        low, high: Limits, in SI units; infinite (or zero, of what is positive) where none are.
        prior: Value that was expected, in SI units (None: where each starts), and by which part
            of it the truth may differ (one standard deviation); None without one.
        span: The entry.
    """

    what: str
    of: str
    per: Per
    members: Indices
    along: Floats | None
    dimension: Dimension
    low: float
    high: float
    prior: tuple[float | None, float] | None
    span: Span


class Data(Struct, frozen=True, eq=False):
    """One measurement: a file, and how the scene was set for it.

    Attributes:
        overrides: As of ``--set``: "depth = 2 mm".
        held_out: Whether it is only used to judge what was learnt.
        start: Time of its clock at which the run begins [s]; earlier rows are not used.
    """

    path: Path
    overrides: tuple[str, ...]
    held_out: bool
    span: Span
    start: float = 0.0


class DataAxis(Struct, frozen=True, eq=False):
    """The column by which rows of tables are ordered.

    Attributes:
        nodes: Where there is no time: the moved nodes whose displacement the column holds, and
            the net is in equilibrium in each row. None for a time.
        column: None: the first column, in seconds or as its name ends (``t_ms``).
        along: Unit vector along which displacements have a sign, shape (3,); None: they count
            from where nodes are drawn to where they end.
    """

    nodes: Indices | None
    column: DataColumn | None
    span: Span
    along: Floats | None = None


#: Errors that an expectation can use: "held out", or the name of a file, or "data".
Errors = Mapping[str, float]


class Demand(Struct, frozen=True, eq=False):
    """``expect error(held out) < 8 %``: evaluated when the learning is over.

    Attributes:
        holds: Of the errors, each relative to what was measured.
        describe: What was measured, such as "error(held out) = 3.1 %".
    """

    holds: Callable[[Errors], bool]
    describe: Callable[[Errors], str]
    span: Span


class FitProblem(Struct, frozen=True, eq=False):
    """A ``learn`` block.

    Attributes:
        name: Of the block, which often is that of a tissue.
        last_part: Part of each experiment, at its end, that is held out.
        revise: Names of rules that may be revised.
        passes: How often the optimiser may be begun again from where it came to.
        bootstrap: How many fits to simulated data give the intervals; None: derivatives
            give them.
        tolerance: Relative change of the error at which it is over.
        integrator: "automatic", or the name of the method whose steps are learnt through.
        step: [s]; None: chosen.
        method: "automatic", "least squares" or "l-bfgs-b".
        scaled: Whether errors count in units of the noise; otherwise as they are, which is the
            paper's error function.
        write: Where the preset goes; None if nowhere.
    """

    name: str
    data: tuple[Data, ...]
    axis: DataAxis
    fits: tuple[Fit, ...]
    adjusts: tuple[Adjust, ...]
    last_part: float
    revise: tuple[str, ...]
    passes: int
    bootstrap: int | None
    seed: int
    tolerance: float
    integrator: str
    step: float | None
    method: str
    scaled: bool
    write: Path | None
    demands: tuple[Demand, ...]
    span: Span
