"""Between which numbers the graded quantities of a scene lie, for explanations."""

from collections.abc import Iterator

import numpy as np
from msgspec import Struct

from tissuec.compiler.compile import Compiled
from tissuec.compiler.materials.tissue_parts import TissueParts
from tissuec.model.network import Floats
from tissuec.scene.model import AssignedQuantity
from tissuec.scene.reading.findings import Findings
from tissuec.scene.tissues.quantities import QUANTITIES


class GradedRange(Struct, frozen=True):
    """A quantity that depends on the place.

    Attributes:
        body: The body.
        owner: The body, or the region of it that grades the quantity.
        quantity: Its name.
        low, high: Its smallest and largest number at elements, springs or nodes, in its SI
            unit.
        shown: Both with their unit.
        formula: As written.
        place: ``file:line``.
    """

    body: str
    owner: str
    quantity: str
    low: float
    high: float
    shown: str
    formula: str
    place: str


def graded_ranges(compiled: Compiled) -> Iterator[GradedRange]:
    """Yield the quantities that depend on the place, body by body."""
    for placed in compiled.groups.bodies.values():
        body = placed.drawing.body
        for owner, given, numbers in _graded(TissueParts(placed.drawing, Findings())):
            assert given.formula is not None
            if not len(numbers):
                continue
            quantity, low, high = given.quantity, float(numbers.min()), float(numbers.max())
            shown = f"{quantity.show(low)} to {quantity.show(high)}"
            yield GradedRange(
                body.name, owner, quantity.name, low, high, shown,
                given.formula.span.one_line, given.span.place,
            )  # fmt: skip


def _graded(parts: TissueParts) -> Iterator[tuple[str, AssignedQuantity, Floats]]:
    """Yield the quantities that depend on the place, with their owners and numbers.

    The numbers are those of elements, of springs or of nodes, in the SI unit of the quantity,
    shape (n,).
    """
    drawing = parts.drawing
    for number, material in enumerate(parts.materials):
        given = None if material.tissue is None else material.tissue.given
        for key, one in (given or {}).items():
            if one.formula is None:
                continue
            each = [one if k == number else None for k in range(len(parts.materials))]
            if drawing.element_part is not None:
                own, found = drawing.element_part == number, parts.at_elements(each)
            elif QUANTITIES[key].array == "mass":
                own, found = drawing.part == number, parts.at_nodes(each)
            else:
                own = (drawing.part[drawing.mesh.ends] == number).any(axis=1)
                found = parts.at_springs(each, np.where(own, number, -1), None)
            yield material.name, one, found[own]
