"""Laws and all their partial derivatives as functions of plain numbers, for learning.

Constants of laws that may change are variables called ``k[0]``, ``k[1]``, … of the formulas;
they reach the functions as an array k.
"""

from collections.abc import Callable, Sequence
from functools import cache

from tissuec.laws import Law
from tissuec.laws.code import choosing, made_of
from tissuec.laws.formula import ZERO, Formula


def constant_name(number: int) -> str:
    """Return the variable of a constant that may change."""
    return f"k[{number}]"


@cache
def functions(laws: tuple[Law, ...], constants: int) -> dict[str, Callable[..., float]]:
    """Return the functions by name.

    Those of springs take (law, e, c, rest, k), those of dashpots (law, e, w, d, rest, k), and
    ``by_constant`` takes (law, number of the constant, e, w, c, d, rest, k).

    Args:
        laws: The first is ``LINEAR``.
        constants: How many constants may change.
    """
    elastic, viscous = [law.elastic for law in laws], [law.viscous for law in laws]

    def derived(formulas: Sequence[Formula], name: str) -> list[Formula]:
        return [formula.slope(name) for formula in formulas]

    written = {
        "pull": ("e, c", elastic),
        "slope": ("e, c", derived(elastic, "e")),
        "pull_by_c": ("e, c", derived(elastic, "c")),
        "pull_by_rest": ("e, c", derived(elastic, "rest")),
        "brake": ("e, w, d", viscous),
        "brake_slope": ("e, w, d", derived(viscous, "w")),
        "brake_by_e": ("e, w, d", derived(viscous, "e")),
        "brake_by_d": ("e, w, d", derived(viscous, "d")),
        "brake_by_rest": ("e, w, d", derived(viscous, "rest")),
    }
    found = {
        name: choosing(name, f"{at}, rest, k", formulas)
        for name, (at, formulas) in written.items()
    }
    found["by_constant"] = _by_constant(elastic, viscous, constants)
    return found


def _by_constant(
    elastic: Sequence[Formula], viscous: Sequence[Formula], constants: int
) -> Callable[..., float]:
    lines = ["def law_function(law, number, e, w, c, d, rest, k):"]
    for law, both in enumerate(zip(elastic, viscous, strict=True)):
        for number in range(constants):
            one, two = (formula.slope(constant_name(number)) for formula in both)
            if (total := one + two) != ZERO:
                lines += [f"    if law == {law} and number == {number}:"]
                lines += [f"        return {total.code()}"]
    return made_of("by_constant", [*lines, "    return 0.0"])
