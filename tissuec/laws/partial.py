"""Laws of springs with all their partial derivatives, for learning.

Constants of laws that may change are variables called ``k[0]``, ``k[1]``, … of the formulas.
"""

from collections.abc import Sequence

from tissuec.laws import Law
from tissuec.laws.formula import Formula

_SPRING, _DASHPOT = ("e", "c", "rest"), ("e", "w", "d", "rest")
#: What the formulas are of, besides constants that may change, by their names.
ARGUMENTS = {
    **dict.fromkeys(("pull", "slope", "pull_by_c", "pull_by_rest"), _SPRING),
    **dict.fromkeys(
        ("brake", "brake_slope", "brake_by_e", "brake_by_d", "brake_by_rest"), _DASHPOT
    ),
    "by_constant": ("e", "w", "c", "d", "rest"),
}


def constant_name(number: int) -> str:
    """Return the variable of a constant that may change."""
    return f"k[{number}]"


def formulas(laws: Sequence[Law], constants: int) -> dict[str, list[Formula]]:
    """Return the formulas of every law that kernels need.

    Of ``by_constant``, there is one for each constant of each law.

    Args:
        constants: How many constants may change.
    """
    elastic, viscous = [law.elastic for law in laws], [law.viscous for law in laws]

    def slopes(members: Sequence[Formula], name: str) -> list[Formula]:
        return [formula.slope(name) for formula in members]

    return {
        "pull": elastic,
        "slope": slopes(elastic, "e"),
        "pull_by_c": slopes(elastic, "c"),
        "pull_by_rest": slopes(elastic, "rest"),
        "brake": viscous,
        "brake_slope": slopes(viscous, "w"),
        "brake_by_e": slopes(viscous, "e"),
        "brake_by_d": slopes(viscous, "d"),
        "brake_by_rest": slopes(viscous, "rest"),
        "by_constant": [
            law.elastic.slope(name) + law.viscous.slope(name)
            for law in laws
            for name in map(constant_name, range(constants))
        ],
    }
