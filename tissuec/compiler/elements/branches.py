"""Branches of elements that relax, from the shares of tissues.

A share s of the modulus of a sudden strain relaxes; with the sum S of all shares of a tissue
and the modulus μ that is left in the end, the modulus of its branch is μ s/(1 - S).
"""

from typing import TYPE_CHECKING

import numpy as np

from tissuec.compiler.materials.tissue_parts import TissueParts, part_numbers
from tissuec.model.inelastic import CONSTANTS, TIMES
from tissuec.model.network import Floats, Indices
from tissuec.scene.model import AssignedQuantity
from tissuec.scene.tissues.quantities import OF_MATTER, QUANTITIES

if TYPE_CHECKING:
    from tissuec.forces.solids.element_memory import Branches


def branches_of(
    parts: TissueParts, part: Indices, shear: Floats, directions: int
) -> "Branches | None":
    """Return the branches of elements, without storage; None if nothing relaxes.

    Args:
        parts: Of the body.
        part: Of each element, shape (element,).
        shear: Shear modulus of each element in the end [Pa], shape (element,).
        directions: 3 in solids, 2 in walls.
    """
    from tissuec.forces.solids.element_memory import Branches

    rows: list[tuple[Floats, Floats]] = []
    for constant, name in zip(CONSTANTS, TIMES, strict=True):
        shares, times = parts.found(constant), parts.found(name)
        ratio = np.zeros(len(shares))
        used: list[AssignedQuantity | None] = [None] * len(shares)
        for number in part_numbers(part):
            share, lasting = shares[number], times[number]
            if share is None and lasting is None:
                continue
            if share is None or lasting is None:
                said, lacking = (share, name) if share else (lasting, OF_MATTER[constant][0])
                parts.refuse_half(said, name, QUANTITIES[lacking], parts.body.span)
            if share.quantity.is_of_matter and np.isfinite(lasting.value):
                used[number] = lasting
                ratio[number] = share.value / (1.0 - parts.relaxing_beside(share))
        rows.append((ratio[part] * shear, parts.at_elements(used, np.inf)))
    moduli, times = map(np.array, zip(*rows, strict=True))
    exists = moduli.any(axis=1)
    return Branches.new(moduli[exists], times[exists], directions) if exists.any() else None
