"""The numbers of a net as a function of the numbers of its tissues and forces.

A number of a tissue changes every entry of the arrays that is made of it, whatever shares and
interfaces do. Compiling is linear in it, so that a small difference gives its derivative to
rounding, and a net is a sum that nothing is compiled for. It is not linear where the softer of
two tissues decides, in shares that relax, or where a retardation time is learnt beside a
Young's modulus; what a force makes of its numbers may be anything.
"""

from tissuec.compiler.compile import Compiled
from tissuec.learn.parameters.fields import every_field
from tissuec.learn.parameters.numbers import NO_FIELDS, NumberOrder
from tissuec.learn.parameters.substitution import Number, Numbers, UsePlace, recompiled
from tissuec.model.inelastic import TIMES, VISCOSITY
from tissuec.model.network import Floats
from tissuec.scene.tissues.quantities import (
    POISSONS_RATIO,
    RETARDATION_TIME,
    SHARES,
    YOUNGS_MODULUS,
)

STEP = 2.0**-20  # of a number, by which what is linear in it is derived


class Compilations:
    """Nets of a scene with other numbers in its tissues and forces.

    Args:
        compiled: The scene as one experiment has it.
        variables: Constants of laws that may change, as variables of formulas.
        first: Numbers of tissues and forces at the beginning.
    """

    def __init__(
        self, compiled: Compiled, order: NumberOrder, variables: Numbers, first: Numbers
    ):
        self._compiled, self._order = compiled, order
        self._variables, self._first = variables, first
        # Which of two tissues is the softer decides for all of their springs.
        bodies = compiled.scene.bodies.values()
        rules = {body.interface for body in bodies}
        rules |= {part.rule for body in bodies for part in body.spring_parts}
        self._is_linear = rules <= {"", "mean"}
        # A retardation time is multiplied by a Young's modulus.
        words = {word for _, word in first}
        self._is_linear &= not {YOUNGS_MODULUS, RETARDATION_TIME} <= words
        self._is_linear &= words.isdisjoint(SHARES)
        # Bulk moduli and hinges are not linear in Poisson's ratio, nor in what damps these.
        self._is_linear &= words.isdisjoint({POISSONS_RATIO, *TIMES, VISCOSITY})
        self._is_linear &= compiled.network.hinges is None
        self._is_linear &= all(isinstance(place, UsePlace) for place, _ in first)
        self._columns: dict[Number, Floats] = {}
        self._at: tuple[float, ...] | None = None  # where the columns hold, if anywhere
        self._base: Floats | None = None

    def vector(self, given: Numbers) -> Floats:
        """Return the numbers of the net in SI units, with 0 for those of laws, shape (number,).

        Raises:
            CompileError: The numbers make no scene.
        """
        if not self._is_linear:
            return self._made(given)
        total = self._begun().copy()
        for key, value in given.items():
            if value != self._first[key]:
                total += (value - self._first[key]) * self.column(key, given)
        return total

    def column(self, key: Number, given: Numbers) -> Floats:
        """Return the derivative by one of these numbers, in SI units, shape (number,).

        Args:
            key: The number.
            given: Present numbers.

        Raises:
            CompileError: The numbers make no scene.
        """
        if not self._is_linear and self._at != tuple(given.values()):
            self._at, self._columns, self._base = tuple(given.values()), {}, self._made(given)
        if key not in self._columns:
            here = self._first if self._is_linear else given
            step = STEP * (abs(here[key]) or 1.0)
            moved = self._made({**here, key: here[key] + step})
            before, apart = self._begun(), step
            if not self._is_linear:
                before, apart = self._made({**here, key: here[key] - step}), 2.0 * step
            self._columns[key] = (moved - before) / apart
        return self._columns[key]

    def _begun(self) -> Floats:
        """Return the numbers from which differences are taken."""
        if self._base is None:
            self._base = self._made(self._first)
        return self._base

    def _made(self, given: Numbers) -> Floats:
        """Return the numbers of a net that is compiled."""
        found = recompiled(self._compiled, given, self._variables)
        fields = every_field(found.plan, found.network) if self._order.fields else NO_FIELDS
        return self._order.vector(found.network, fields)
