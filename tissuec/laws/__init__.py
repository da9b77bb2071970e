"""Laws of springs and dashpots: a member is a ``Struct`` with its formula.

A spring pulls with f(e) + g(e, w), e being its elongation and w the speed at which it
lengthens (the paper's equation 8; its SpringFunction and ViscosityFunction, equations 5 and 6,
are f and a g of w alone). Formulas may use the spring constant c or the viscosity d of the
spring, and its rest length ``rest``. Where nothing moves, g is zero.
"""

from typing import Protocol

from msgspec import Struct

from tissuec.core.registry import Family
from tissuec.laws.formula import Constant, Formula, Product, Variable, replaced, variables

E, C, W, D, REST = (Variable(name) for name in ("e", "c", "w", "d", "rest"))
STRAIN, MODULUS = Variable("strain"), Variable("modulus")


class Law(Struct, frozen=True, eq=False):
    """The law of a spring and its dashpot.

    Attributes:
        name: For people.
        elastic: Force [N] of ``e`` [m], ``c`` [N/m] and ``rest`` [m].
        viscous: Force [N] of ``e`` [m], ``w`` [m/s], ``d`` [N s/m] and ``rest`` [m]; zero
            where w is.
        spring, dashpot: The members of the families that say so; None for free formulas.
        modulus: Young's modulus [Pa] that a law of stress refers to.
    """

    name: str
    elastic: Formula
    viscous: Formula
    spring: "SpringLaw | None" = None
    dashpot: "ViscosityLaw | None" = None
    modulus: float = 1.0

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Law) and self._force == other._force

    def __hash__(self) -> int:
        return hash(self._force)

    @property
    def _force(self) -> tuple[str, Formula, Formula]:
        return self.name, self.elastic, self.viscous


def is_open(law: Law) -> bool:
    """Return whether a law has constants without numbers: those that learning changes."""
    known = {one.name for one in (E, C, W, D, REST)}
    return not variables(law.elastic) | variables(law.viscous) <= known


LINEAR = Law("linear", C * E, D * W)


def of_stress(stress: Formula) -> Formula:
    """Return the force of a spring of matter [N].

    A spring of stiffness c represents a bar with the section c L0 / E.

    Args:
        stress: Of ``strain``, which is e/L0, and ``modulus``, which is E [Pa].
    """
    return Product(C * REST / MODULUS, replaced(stress, {STRAIN.name: E / REST}))


def stress_in(force: Formula) -> Formula | None:
    """Return the stress from which a force follows, of e/L0; None where it does not."""
    if MODULUS.name not in variables(force):
        return None
    assert isinstance(force, Product)
    return force.right


def with_modulus(force: Formula, modulus: float) -> Formula:
    """Return a force with Young's modulus [Pa] as a number."""
    return replaced(force, {MODULUS.name: Constant(modulus)})


class SpringLaw(Protocol):
    """Interface of members of ``SPRING_LAWS``; their fields are entries in the language."""

    def force(self) -> Formula:
        """Return the force [N] as a formula of e, c and rest."""
        ...


class ViscosityLaw(Protocol):
    """Interface of members of ``VISCOSITY_LAWS``; their fields are entries."""

    def force(self) -> Formula:
        """Return the force [N] as a formula of e, w, d and rest."""
        ...


SPRING_LAWS: Family[type[SpringLaw]] = Family("tissuec.laws.spring", "spring law")
VISCOSITY_LAWS: Family[type[ViscosityLaw]] = Family("tissuec.laws.viscosity", "viscosity law")
