"""Check of walls of elements whose triangles do not bend as a plate of their tissue would."""

from collections.abc import Iterator

import numpy as np

from tissuec.compiler.checks import check
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import Diagnostic
from tissuec.core.names import key_of

#: Of the energy of a plate: nets that sag right to 5 % have bounds between these.
LEAST, MOST = 0.85, 1.1


@check
def uneven_walls(compiled: Compiled) -> Iterator[Diagnostic]:
    """W212: walls whose triangles are so uneven that they bend unlike their tissue."""
    bent = {field.name for field in compiled.network.of_kind("plates")}
    for wall in compiled.network.of_kind("membranes"):
        if wall.name not in bent:
            continue
        from tissuec.matter.plate import patches  # where walls need it

        ratio = -wall.thinning / (1.0 - wall.thinning)
        rigidity = wall.shear * wall.thickness**3 / (6.0 * (1.0 - ratio))
        placed = compiled.groups.bodies[key_of(wall.name)]
        bounds = patches(placed.drawing.mesh).bounds(rigidity, ratio)
        low, high = float(np.min(bounds)), float(np.max(bounds))
        if low >= LEAST and high <= MOST:
            continue
        yield Diagnostic(
            "W212",
            f"{wall.name} does not bend like its tissue: depending on how it is bent, its "
            f"triangles store between {low:.2g} and {high:.3g} times the energy of a plate",
            wall.span,
            "use a mesh whose neighbouring triangles are alike, such as squares divided by "
            "parallel diagonals, or write bending is none if bending does not matter",
        )
