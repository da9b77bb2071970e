"""Nets on paper: springs coloured by their tension, skins in the light of a lamp."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tissuec.core.palette import INK, LUMEN, SKIN, STEEL, TENSION
from tissuec.model.network import Floats, Network
from tissuec.view.plots.projection import Projection

if TYPE_CHECKING:
    from matplotlib.colors import Colormap, Normalize

    from tissuec.view.plots.drawing import Axes

LAMP = np.array([-0.35, -0.55, 0.76])
RIM = "#5a2a22"
PALEST = 0.3  # how much is seen of what is furthest away
DEEP = 0.2  # of the largest side: a net that reaches so far back fades to the palest
MANY = 20_000  # springs or triangles: vector files hold so many as a picture
MOST = 99.0  # per cent of the tensions that the scale of colours spans


def tension_colours() -> "Colormap":
    """Return the colours from pressure over nothing to tension."""
    return colours_between(TENSION)


def colours_between(shades: Sequence[str]) -> "Colormap":
    """Return the colours between some shades, the lowest first."""
    from matplotlib.colors import LinearSegmentedColormap

    return LinearSegmentedColormap.from_list("shades", list(shades))


def tension_norm(tensions: Sequence[NDArray[np.floating]]) -> "Normalize":
    """Return a symmetric scale that includes most tensions of all frames.

    Args:
        tensions: Of each frame [N], shape (spring,).
    """
    from matplotlib.colors import Normalize

    every = np.abs(np.concatenate([np.zeros(0), *tensions]))
    largest = float(np.percentile(every, MOST)) if len(every) else 0.0
    largest = largest or float(every.max(initial=0.0)) or 1.0
    return Normalize(-largest, largest)


def draw_springs(
    axes: "Axes",
    ends: Floats,
    view: Projection,
    *,
    colours: NDArray[Any],
    width: float | Floats = 0.9,
) -> Any:
    """Draw springs, more distant ones first and paler.

    Args:
        ends: Of each spring, in the unit of the axes, shape (spring, 2, 3).
        colours: Red, green, blue and opacity of each spring, shape (spring, 4).
        width: Of the lines [pt], one or shape (spring,).
    """
    from matplotlib.collections import LineCollection

    near = view.nearness(ends.mean(axis=1))
    order = np.argsort(near, kind="stable")
    depth = float(np.ptp(near)) if len(near) else 0.0
    if depth > 0.0:
        # A sheet that is hardly bent looks flat: what is far counts by the size of the net.
        size = float(np.ptp(ends, axis=(0, 1)).max())
        most = (1.0 - PALEST) * min(1.0, depth / (DEEP * size))
        paler = 1.0 - most * (near.max() - near) / depth
        colours = np.column_stack([colours[:, :3], colours[:, 3] * paler])
    widths = np.broadcast_to(width, (len(ends),))[order]
    flat = view.flat(ends)[order]
    lines = LineCollection(list(flat), colors=colours[order], linewidths=widths)
    lines.set_capstyle("round")
    lines.set_rasterized(len(ends) > MANY)
    return axes.add_collection(lines)


def draw_skin(
    axes: "Axes",
    position: Floats,
    triangles: NDArray[np.integer],
    view: Projection,
    *,
    rims: bool,
    own: Floats | None = None,
) -> Any:
    """Draw triangles in the light of a lamp, more distant ones first.

    Args:
        position: Of their corners, in the unit of the axes, shape (node, 3).
        triangles: Shape (triangle, 3).
        rims: Whether the edges are drawn.
        own: Colours of the triangles, hardly shaded, shape (triangle, 3); those of tissue if
            None.
    """
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_rgb

    corners = position[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
    order = np.argsort(view.nearness(corners.mean(axis=1)), kind="stable")
    outside = (normal @ view.towards > 0.0)[order]
    light = (0.3 + 0.7 * np.abs(normal @ LAMP) ** 1.5)[order, None]
    tones = np.where(outside[:, None], to_rgb(SKIN), to_rgb(LUMEN))
    if own is not None:  # as bright as on the page, so that it can be compared with the scale
        tones, light = own[order], 0.84 + 0.16 * np.minimum(light, 1.0)
    colours = np.clip(light * tones, 0.0, 1.0)
    flat = view.flat(corners)[order]
    edges = RIM if rims else colours
    skin = PolyCollection(list(flat), facecolors=colours, edgecolors=edges, linewidths=0.35)
    skin.set_rasterized(len(triangles) > MANY)
    return axes.add_collection(skin)


def draw_nodes(axes: "Axes", position: Floats, view: Projection, *, colour: str = INK) -> None:
    """Draw nodes that have no spring."""
    if len(position):
        x, y = view.flat(position).T
        axes.plot(x, y, "o", color=colour, markersize=4, zorder=3)


def draw_tool(axes: "Axes", points: Floats, radius: float, view: Projection) -> None:
    """Draw all points within a radius of a line.

    Args:
        points: Ends of the line, in the unit of the axes, shape (2, 3).
        radius: The radius, in the same unit.
    """
    from matplotlib.patches import Polygon

    (x0, y0), (x1, y1) = view.flat(points)
    along = np.arctan2(y1 - y0, x1 - x0)
    half = np.linspace(-np.pi / 2.0, np.pi / 2.0, 33)
    caps = [
        np.stack([x + radius * np.cos(turn), y + radius * np.sin(turn)], axis=-1)
        for x, y, turn in ((x1, y1, along + half), (x0, y0, along + np.pi + half))
    ]
    outline = np.concatenate(caps)
    axes.add_patch(
        Polygon(outline, facecolor=STEEL, edgecolor=INK, alpha=0.45, linewidth=0.6, zorder=2)
    )


def draw_silhouette(
    axes: "Axes",
    position: Floats,
    triangles: NDArray[np.integer],
    view: Projection,
    *,
    colour: str,
    opacity: float,
) -> None:
    """Draw a closed surface as one paler area with its outlines.

    Args:
        position: Of its points, in the unit of the axes, shape (point, 3).
        triangles: Shape (triangle, 3).
        colour: Of the area.
        opacity: Of the area.
    """
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    flat = view.flat(position)
    a, b, c = np.moveaxis(flat[triangles], 1, 0)
    turn = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    front = triangles[turn > 0.0]
    if not len(front):
        return
    # All turn the same way, so that they are filled as one area wherever they overlap.
    area = Path(*_lines(np.concatenate([flat[front], flat[front[:, :1]]], axis=1)))
    edges = np.sort(front[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    single, count = np.unique(edges, axis=0, return_counts=True)
    outline = Path(*_lines(flat[single[count == 1]]))
    style: Any = {"alpha": opacity, "zorder": 2}
    axes.add_patch(PathPatch(area, facecolor=colour, edgecolor="none", **style))
    axes.add_patch(PathPatch(outline, facecolor="none", edgecolor=INK, linewidth=0.6, **style))


def _lines(points: Floats) -> tuple[Floats, Any]:
    """Return lines, shape (line, point, 2), as the points and codes of one path."""
    from matplotlib.path import Path

    codes = np.full(points.shape[:2], Path.LINETO)
    codes[:, 0] = Path.MOVETO
    return points.reshape(-1, 2), codes.reshape(-1)


def thread_springs(network: Network) -> NDArray[np.bool_]:
    """Return which lines belong to chains: threads and slings, shape (line,)."""
    chains = np.zeros(network.line_count, dtype=bool)
    for body in network.bodies:
        ends = network.line_ends[body.lines] - body.nodes.start
        count = body.nodes.stop - body.nodes.start
        pairs = np.unique(np.sort(ends, axis=1), axis=0)
        degree = np.bincount(pairs.ravel(), minlength=count)
        chains[body.lines] = count > 3 and len(pairs) >= count - 1 and degree.max() <= 2
    return chains
