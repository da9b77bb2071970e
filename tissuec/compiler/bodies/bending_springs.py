"""Springs that resist bending, which a body has besides those of its mesh.

They are linear, a part as stiff as a spring of their length, and break at the strain at which
springs at their ends do on average, as far as these are linear, too.
"""

from collections.abc import Mapping

import numpy as np

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.compiler.materials.spring_parts import SpringParts
from tissuec.compiler.materials.tissue_parts import TissueParts, part_numbers
from tissuec.core.errors import Note
from tissuec.model.inelastic import CONSTANTS, LIMIT, VISCOSITY
from tissuec.model.network import Explained, Floats, Origin, Provenance


def with_bending(
    drawing: Drawing, parts: TissueParts, springs: SpringParts, arrays: Mapping[str, Explained]
) -> dict[str, Explained]:
    """Return the arrays of springs, with those of bending ones changed.

    Args:
        drawing: The body as drawn.
        parts: What tissues say.
        springs: The parts at the ends of springs.
        arrays: By name, as tissues and tables say them of springs, shape (spring,) each.

    Raises:
        CompileError: The tissue lacks what bending springs need.
    """
    bending, bends = drawing.body.bending, drawing.bends
    if bending is None:
        return dict(arrays)
    for name in ("spring constant", "viscosity"):
        found = parts.found(name)
        for number in part_numbers(springs.ends[bends]):
            if found[number] is None:
                needed = Note("needed by its bending springs", bending.span)
                parts.missing(name, parts.materials[number], needed)
    part = bending.part
    pull = arrays["stiffness"][0] * drawing.length  # of each spring at a strain of 1
    own, beside = pull[bends], _beside(drawing, pull)
    known = (own > 0.0) & (beside > 0.0)
    stronger = part * np.where(known, own, 1.0) / np.where(known, beside, 1.0)
    factors = {"stiffness": part, "damping": part, "strength": stronger, "crush": stronger}
    factors |= dict.fromkeys((*CONSTANTS, VISCOSITY), part) | {LIMIT: stronger}
    origin = Origin(bending.span, "bending")
    changed = {
        name: _times(drawing, arrays[name], factor, origin)
        for name, factor in factors.items()
        if name in arrays
    }
    return {**arrays, **changed}


def _beside(drawing: Drawing, values: Floats) -> Floats:
    """Return the mean over the mesh's own springs at the ends of each bending spring."""
    bends, ends, count = drawing.bends, drawing.mesh.ends, len(drawing.part)
    own, both = ends[~bends], ends[bends]
    total = sum(np.bincount(end, values[~bends], count) for end in own.T)
    degree = np.bincount(own.ravel(), minlength=count)
    return np.asarray(total)[both].sum(axis=1) / np.maximum(degree[both].sum(axis=1), 1)


def _times(
    drawing: Drawing, explained: Explained, factor: Floats | float, origin: Origin
) -> Explained:
    """Return an array with the numbers of bending springs multiplied by a factor."""
    values, provenance = explained
    values = values.copy()
    values[drawing.bends] *= factor
    origins = (*provenance.origins, origin)
    index = np.where(drawing.bends, len(origins) - 1, provenance.index)
    return values, Provenance(index.astype(np.int32), origins)
