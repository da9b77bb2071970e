"""Which parts of a body its springs belong to, and what springs between two parts are made of.

A spring between two regions follows the body's ``interface``, unless something is said of the
spring itself.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.compiler.materials.tissue_parts import TissueParts, part_numbers
from tissuec.core.source import Span
from tissuec.model.network import Floats, Origin
from tissuec.scene.bodies.parts import INTERFACES
from tissuec.scene.reading.findings import Findings

#: What springs between two parts may be made of.
_RULES = ("", *INTERFACES)
_SAYS_NOTHING, _MEAN, _SOFTER, _ = range(len(_RULES))


class SpringParts:
    """The parts at both ends of each spring, and the rule for springs between two parts.

    Springs that have a tissue of their own are added to the parts.

    Attributes:
        ends: Numbers of parts, shape (spring, 2).
        is_inner: Whether both are the same, shape (spring,).
    """

    def __init__(self, drawing: Drawing, parts: TissueParts, findings: Findings):
        self._body, self._parts, self._findings = drawing.body, parts, findings
        self.ends = drawing.part[drawing.mesh.ends]
        #: Places in ``_RULES``, shape (spring,).
        self._rule = np.full(len(self.ends), _RULES.index(self._body.interface), dtype=np.int8)
        for number, part in enumerate(self._body.spring_parts, start=1):
            chosen = drawing.spring_part == number
            if part.rule:
                self._rule[chosen] = _RULES.index(part.rule)
            else:
                self.ends[chosen] = parts.add(part)
        if drawing.thread is not None:  # a knot leads from end to end, whatever is said
            knots = np.array(drawing.thread.knots)
            self._rule[knots[self._rule[knots] == _SAYS_NOTHING]] = _SOFTER
        self.is_inner = self.ends[:, 0] == self.ends[:, 1]
        self._need_an_interface()

    def _need_an_interface(self) -> None:
        """Reject springs between regions whose material nothing defines."""
        is_open = ~self.is_inner & (self._rule == _SAYS_NOTHING)
        if not is_open.any():
            return
        first, second = self.names(int(np.argmax(is_open)))
        self._findings.reject(
            "TIS304",
            f"the material of springs from {first} to {second} is missing",
            self._body.span,
            hint=f"write interface is softer from {first} to {second}, "
            "or interface is softer, for all other pairs",
        )

    def names(self, spring: int) -> list[str]:
        """Return the names of the parts at both ends of a spring."""
        return [self._parts.materials[int(part)].name for part in self.ends[spring]]

    @property
    def is_mean(self) -> NDArray[np.bool_]:
        """Return which springs are the mean of two parts, if between two, shape (spring,)."""
        return self._rule == _MEAN

    def joined(
        self, first: Floats, second: Floats, first_is_softer: Callable[[], NDArray[np.bool_]]
    ) -> Floats:
        """Return the values of springs between two parts by their rules, shape (spring,).

        Args:
            first, second: Values of the parts at either end, in any unit, shape (spring,).
            first_is_softer: Returns whether the first end is in the softer part, shape
                (spring,); called only where a rule needs it.
        """
        mean = (first + second) / 2.0
        if not (self._rule > _MEAN).any():
            return mean
        takes_first = first_is_softer() == (self._rule == _SOFTER)
        return np.where(self.is_mean, mean, np.where(takes_first, first, second))

    def origins(
        self, given: list[Origin], where: Span
    ) -> tuple[NDArray[np.int32], list[Origin]]:
        """Return the origin of each spring as an index, shape (spring,), and all origins.

        Args:
            given: Origin of the quantity of each part.
            where: Place in the text that represents interfaces.
        """
        index, origins = self.ends[:, 0].copy(), list(given)
        for rule in part_numbers(self._rule[~self.is_inner]):
            index[~self.is_inner & (self._rule == rule)] = len(origins)
            origins.append(Origin(where, f"interface {_RULES[rule]}"))
        return index, origins
