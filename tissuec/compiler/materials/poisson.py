"""Poisson's ratio: that of springs alone, and the effect of cells that keep their volume.

Springs have both Lamé's constants alike, μ = λ, so that ν is n = 1/4 in a solid (and n = 1/3
where nodes of two kinds shift against one another, see ``matter.solid_springs``). A body of

    μ = E / (2 (1 + ν)),    λ = 2 μ ν / (1 - 2 ν)

is made of springs for μ, and of cells with the bulk modulus (see ``enclosed.volume``)

    K = λ - 2 μ n / (1 - 2 n) = 2 μ (ν - n) / ((1 - 2 ν) (1 - 2 n)).
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from msgspec import Struct

from tissuec.core.errors import Note
from tissuec.core.hints import leaving_out
from tissuec.core.source import Span
from tissuec.scene.model import AssignedQuantity, Body
from tissuec.scene.reading.findings import Findings

if TYPE_CHECKING:
    from tissuec.compiler.materials.matter import Matter

_LEAVE_OUT = "remove it"
_GRADED = (
    "it depends on the place, and all cells of a body use the same bulk modulus",
    "write made of elements in the body",
)
_NEAR = 0.01  # of a wall, whose springs have 1/3: smaller differences are ignored


class Poisson(Struct, frozen=True):
    """How a solid obtains the Poisson's ratio of its tissue.

    Attributes:
        of_springs: The part of their constants that springs have then.
        modulus: Bulk modulus with which cells keep their volume [Pa]; 0 with springs alone.
        span: The entry that requires it.
    """

    of_springs: float
    modulus: float
    span: Span


def poisson_of(
    body: Body,
    matter: "Matter",
    ratios: Sequence[AssignedQuantity | None],
    moduli: Sequence[AssignedQuantity | None],
    findings: Findings,
) -> Poisson | None:
    """Return the way a body gets its Poisson's ratio; an impossible one is rejected.

    Args:
        matter: How its stiffness is distributed to springs.
        ratios: Poisson's ratio of each part of the body that has nodes, at least one.
        moduli: What gives the spring constants of each.

    Returns:
        None where springs have it without cells.
    """
    given = next(one for one in ratios if one is not None)
    if flaw := _flaw(matter, given.value, ratios, moduli):
        why, hint = flaw
        findings.reject(
            "TIS309",
            f"{body.name} cannot have a Poisson's ratio of {given.value:g}: {why}",
            given.span,
            hint=leaving_out(hint, given.span) if hint == _LEAVE_OUT else hint,
            notes=(Note(f"used by {body.name}", body.span),),
        )
    young, ratio, own = moduli[0], given.value, matter.poisson
    if young is None or own is None or not matter.is_solid or ratio == own:
        return None
    shear = young.value / (2.0 * (1.0 + ratio))
    modulus = 2.0 * shear * (ratio - own) / ((1.0 - 2.0 * ratio) * (1.0 - 2.0 * own))
    return Poisson(matter.shears / (2.0 * (1.0 + ratio)), modulus, given.span)


def _shown(ratio: float) -> str:
    return f"1/{round(1.0 / ratio)}"


def _flaw(
    matter: "Matter",
    ratio: float,
    ratios: Sequence[AssignedQuantity | None],
    moduli: Sequence[AssignedQuantity | None],
) -> tuple[str, str] | None:
    """Return why a body cannot have a Poisson's ratio, and what to do; None if it can."""
    if any(one is None or not one.quantity.is_of_matter for one in moduli):
        return "its springs are specified one by one", "write a Young's modulus as well"
    if matter.poisson is None:
        return "it consists of bars, which have no Poisson's ratio", _LEAVE_OUT
    if any(one is not None and one.formula is not None for one in ratios):
        return _GRADED
    if not matter.is_solid:
        if abs(ratio - matter.poisson) <= _NEAR:
            return None
        return "in a surface, springs always give 1/3", _LEAVE_OUT
    if ratio < matter.poisson:
        return f"with springs, the minimum is {_shown(matter.poisson)}", _LEAVE_OUT
    if ratio == matter.poisson:
        return None
    if any(one is not None and one.formula is not None for one in moduli):
        return f"its Young's modulus {_GRADED[0].removeprefix('it ')}", _GRADED[1]
    if (
        len({one and one.value for one in ratios}) > 1
        or len({m and m.value for m in moduli}) > 1
    ):
        return (
            "its regions differ, and all cells of a body use the same bulk modulus",
            "give all its regions the same Young's modulus and Poisson's ratio",
        )
    return None
