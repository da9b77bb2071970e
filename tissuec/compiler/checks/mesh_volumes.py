"""Check of the volumes of cells against those of the regions and shapes that they fill."""

from collections.abc import Iterator

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.compiler.checks import check
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import Diagnostic
from tissuec.core.names import key_of
from tissuec.core.units import VOLUME, show, show_in

MOST = 0.1  # by which a volume may differ


@check
def other_volumes(compiled: Compiled) -> Iterator[Diagnostic]:
    """W213: regions and round bodies whose cells have another volume than is written."""
    for part in compiled.network.bodies:
        drawing = compiled.groups.bodies[key_of(part.name)].drawing
        yield from _of_shape(drawing)
        if not drawing.body.regions or drawing.element_part is None:
            continue
        from tissuec.compiler.elements.region_sizes import region_sizes

        is_wall = drawing.body.is_wall
        for one in region_sizes(drawing):
            if abs(one.size - one.written) <= MOST * one.written:
                continue
            size = show_in(one.size, "mm^2") if is_wall else show(one.size, VOLUME)
            written = show_in(one.written, size.split()[1])
            what = "area" if is_wall else "volume"
            yield Diagnostic(
                "W213",
                f"the elements of the region {one.name} have the {what} {size}, "
                f"{100.0 * abs(one.size / one.written - 1.0):.0f} % "
                f"{'more' if one.size > one.written else 'less'} than its condition "
                f"({written})",
                one.span,
                "cells end at the borders of regions that run between them; elsewhere an "
                "element belongs to the region in which its centre lies: use smaller cells",
            )


def _of_shape(drawing: Drawing) -> Iterator[Diagnostic]:
    """Yield a warning of a round body whose cells have another volume than its shape."""
    body, mesh = drawing.body, drawing.mesh
    shape: float | None = getattr(body.mesh, "shape_volume", None)
    if shape is None or mesh.volume is None:
        return
    for placement in (body.mesh_placement, body.placement):
        shape *= 1.0 if placement is None else placement.volume
    size = float(mesh.volume.sum())
    if abs(size - shape) > MOST * shape:
        share = f"{100.0 * abs(size / shape - 1.0):.0f} %"
        which = "less" if size < shape else "more"
        yield Diagnostic(
            "W213",
            f"{body.name} has {show(size, VOLUME)}, {share} {which} than its shape "
            f"({show(shape, VOLUME)}), and so has its mass",
            body.span,
            "use smaller cells, or more sides: corners of cells lie on the round surface",
        )
