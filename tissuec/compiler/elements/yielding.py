"""Yielding of elements, from the yield stress and the flow viscosity of tissues."""

from typing import TYPE_CHECKING

import numpy as np

from tissuec.compiler.materials.tissue_parts import TissueParts, part_numbers
from tissuec.core.errors import Note
from tissuec.core.names import key_of
from tissuec.model.inelastic import LIMIT, VISCOSITY
from tissuec.model.network import Indices
from tissuec.scene.model import AssignedQuantity
from tissuec.scene.tissues.quantities import BREAKING_STRAIN, OF_MATTER, QUANTITIES

if TYPE_CHECKING:
    from tissuec.forces.solids.element_memory import ElementYield

_PAIRS = ((LIMIT, VISCOSITY), (VISCOSITY, LIMIT))


def yielding_of(parts: TissueParts, part: Indices, directions: int) -> "ElementYield | None":
    """Return the yielding of elements, without storage; None if nothing yields.

    Args:
        parts: Of the body.
        part: Of each element, shape (element,).
        directions: 3 in solids, 2 in walls.
    """
    from tissuec.forces.solids.element_memory import ElementYield

    found = {name: parts.found(name) for name in (LIMIT, VISCOSITY)}
    used: dict[str, list[AssignedQuantity | None]] = {
        name: [None] * len(parts.materials) for name in (LIMIT, VISCOSITY)
    }
    for number in part_numbers(part):
        for name, other in _PAIRS:
            given, lacking = found[name][number], OF_MATTER[other][0]
            if given is not None and found[other][number] is None:
                parts.refuse_half(given, name, QUANTITIES[lacking], parts.body.span)
        stress, fluid = found[LIMIT][number], found[VISCOSITY][number]
        if stress is None or fluid is None or not stress.quantity.is_of_matter:
            continue
        if fluid.quantity.is_of_matter:
            used[LIMIT][number], used[VISCOSITY][number] = stress, fluid
            if np.isfinite(stress.value) and np.isfinite(fluid.value):
                _refuse_idle_limits(parts, number)
    limit, viscosity = (parts.at_elements(used[name], np.inf) for name in (LIMIT, VISCOSITY))
    yields = np.isfinite(limit) & np.isfinite(viscosity)
    if not yields.any():
        return None
    limit, viscosity = (np.where(yields, each, np.inf) for each in (limit, viscosity))
    return ElementYield.new(limit, viscosity, directions)


def _refuse_idle_limits(parts: TissueParts, number: int) -> None:
    """Report a strength or a toughness of elements that yield before reaching it.

    Args:
        parts: Of the body.
        number: Of the part.
    """
    if not parts.body.may_rupture:
        return
    limits = parts.limits()[number]
    has_strain = any(key_of(one.quantity.name) == BREAKING_STRAIN for one in limits)
    for given in limits:
        is_strain = key_of(given.quantity.name) == BREAKING_STRAIN
        if is_strain or not given.quantity.is_of_matter or given.value == given.quantity.none:
            continue
        if has_strain and given.how != "written":
            continue  # rules say both
        parts.findings.add(
            "TIS306",
            f"a {given.quantity.name} is not available for elements that yield: flow limits "
            "what they bear",
            given.span,
            hint="write a breaking strain instead, which includes the plastic strain",
            notes=(Note(f"used by {parts.body.name}", parts.body.span),),
        )
