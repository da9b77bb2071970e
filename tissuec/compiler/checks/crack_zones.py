"""Check of meshes that are too coarse for the zones in which faces of tears soften."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from tissuec.compiler.checks import check
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import Diagnostic
from tissuec.core.units import LENGTH, show
from tissuec.scene.model import Body, Tissue
from tissuec.scene.tissues.quantities import STRENGTH, TOUGHNESS

if TYPE_CHECKING:
    from tissuec.model.network import Floats, Network

ROUNDED = 0.95  # what two digits show is then not above the length


@check
def crack_zones(compiled: Compiled) -> Iterator[Diagnostic]:
    """W218: zones in which faces of tears soften that are too short or too long for a mesh.

    Faces soften along 9π/32 E'G/σ². With the strength of the tissue, that is shorter than an
    element if the mesh cannot represent this strength. With the one that follows from the mesh
    (``ElementLimits.softening``), it is ``SOFTENING`` elements long, and a body of the height
    H that is stretched as a whole reaches this strength before G = σ²H/2E' is there for a long
    tear if H is less than 64/9π of the zone.
    """
    for body in compiled.scene.bodies.values():
        seen = set()
        for tissue in body.tissues if body.tears_by_faces else ():
            tough = tissue.given.get(TOUGHNESS)
            if tough is not None and tough.span not in seen:
                seen.add(tough.span)
                yield from _of_tissue(compiled.network, body, tissue)


def _of_tissue(network: "Network", body: Body, tissue: Tissue) -> Iterator[Diagnostic]:
    from tissuec.forces.solids.element_limits import SOFTENING, ZONE

    tough, strong = tissue.given[TOUGHNESS], tissue.given.get(STRENGTH)
    size, energy = _tough_elements(network, body, tissue)
    if not len(size):
        return
    coarse = float(size.max())
    shown = show(coarse, LENGTH, digits=3)
    if strong is not None and strong.value != strong.quantity.none:
        zone = float((ZONE * energy / strong.value**2).min())
        if zone < coarse:
            yield Diagnostic(
                "W218",
                f"with this strength, tears of {body.name} would soften along "
                f"{show(zone, LENGTH, digits=3)}, less than a cell ({shown}); the strength "
                "follows from the toughness and the cells instead",
                strong.span,
                "leave the strength out",
            )
    fields = network.elements_of(body.name)
    nodes = np.unique(np.concatenate([one.nodes.ravel() for one in fields]))
    across = float(np.sort(np.ptp(network.position[nodes], axis=0))[1])
    zone = SOFTENING * coarse
    if across < (least := 2.0 / ZONE * zone) * (1.0 - 1e-9):
        yield Diagnostic(
            "W218",
            f"{body.name} is {show(across, LENGTH, digits=3)} across, fewer than seven cells: "
            f"a tear softens along {SOFTENING:.0f} cells ({show(zone, LENGTH, digits=3)}), so "
            "that the whole body may soften before the toughness is reached",
            tough.span,
            f"use cells of {show(ROUNDED * coarse * across / least, LENGTH, digits=2)} or less",
        )


def _tough_elements(
    network: "Network", body: Body, tissue: Tissue
) -> tuple["Floats", "Floats"]:
    """Return h [m], and E'G [J Pa/m²], of elements with faces of this toughness, (element,)."""
    from tissuec.forces.moduli import plane_modulus

    origins, span = network.provenance["breaking"], tissue.given[TOUGHNESS].span
    is_tough = np.array([each.span == span for each in origins.origins])
    size, energy = [np.zeros(0)], [np.zeros(0)]
    for field in network.elements_of(body.name):
        if field.limits is None:
            continue
        own = is_tough[origins.index[field.walls - network.line_count]]
        own = np.flatnonzero(own & (field.limits.parting > 0.0))
        plane = plane_modulus(field.shear, field.bulk_modulus)
        size.append(np.cbrt(field.volume[own]))
        energy.append((plane * field.limits.parting)[own])
    return np.concatenate(size), np.concatenate(energy)
