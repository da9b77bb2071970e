"""How large regions of elements are, and how large they are written."""

from collections.abc import Iterator

import numpy as np
from msgspec import Struct

from tissuec.compiler.bodies.drawn import Drawing
from tissuec.compiler.elements.regions import by_shape, chosen, points_within
from tissuec.core.source import Span
from tissuec.geometry.element_samples import samples_within
from tissuec.geometry.elements import SHAPES
from tissuec.model.network import Floats

#: Places at which a condition is examined to find its volume: a tenth of a second.
SAMPLES = 200_000
FEWEST, MOST = 8, 2_000  # of them within each element


class RegionSize(Struct, frozen=True, eq=False):
    """How large a region is, and how large it is written.

    Attributes:
        name: Of the region.
        span: Where it is written.
        size: Volume of its elements [m³], or area of those of a wall [m²], as drawn.
        written: That of the part of all elements in which its condition holds.
    """

    name: str
    span: Span
    size: float
    written: float


def region_sizes(drawing: Drawing) -> Iterator[RegionSize]:
    """Yield the sizes of the regions of a body that consists of elements."""
    regions, mesh = drawing.body.regions, drawing.mesh
    if not regions or drawing.element_part is None or drawing.scope is None:
        return
    many = int(np.clip(SAMPLES // len(drawing.element_part), FEWEST, MOST))
    size, written = np.zeros(len(regions)), np.zeros(len(regions))
    for number, one in zip(by_shape(drawing.element_part, mesh), mesh.elements, strict=True):
        corners = mesh.position[one.nodes]
        sizes = _sizes(one.shape, corners)
        weights = samples_within(one.shape, many)
        size += np.bincount(number, sizes, len(regions) + 1)[1:]
        places = np.einsum("pa,eak->epk", weights, corners[:, : weights.shape[1]])
        points = points_within(
            mesh, one, drawing.scope, drawing.described(places.reshape(-1, 3)), many
        )
        holds = chosen(points, [region.where for region in regions])
        written += holds.reshape(len(regions), -1, many).mean(axis=2) @ sizes
    for region, own, meant in zip(regions, size.tolist(), written.tolist(), strict=True):
        yield RegionSize(region.name, region.span, own, meant)


def _sizes(shape: str, corners: Floats) -> Floats:
    """Return the volumes [m³] or areas [m²] of elements, shape (element,).

    Args:
        shape: Of all of them.
        corners: Positions of their nodes [m], shape (element, node, 3).
    """
    if shape in SHAPES:
        return SHAPES[shape].volumes(corners)
    a, b, c = corners[:, :3].swapaxes(0, 1)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
