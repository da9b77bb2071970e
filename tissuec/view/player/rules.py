"""Numbers by which pages and pictures draw alike, colours of numbers, and lines in dashes."""

import numpy as np
from msgspec import Struct
from msgspec.structs import asdict

from tissuec.core.arrays import counted_up
from tissuec.model.network import Floats, Indices


class DrawingRules(Struct, frozen=True):
    """Numbers by which pages and pictures draw alike.

    Attributes:
        lamp: Direction to the lamp, as the eye sees it.
        gloss: Of the highlight on tools and threads.
        shine: Of the highlight on tissue that has a gloss of 1.
        haze: Part of the paper in solids that are furthest away.
        fog: The same of springs.
        held: Of the colour of tools, on skin that is held.
        paler: Of the paper, on skin under springs, whose colours say something.
        unknown: Grey of nodes at which a field is unknown.
        lit: Part of a colour of a field that shade leaves at least, as legends show it.
        nearer: Of the size of the scene, by which lines lie on the skin.
        pressed: Of the scale: springs that are pressed more are dashed.
        dashes: How many dashes a spring of usual length has.
        inked: Part of a dash that is drawn.
        marker: Radius of a lonely node, of the size of the scene.
        marker_rest: The most that it has, of the usual length of springs.
        opening: Length of the tube behind an opening, of the size of the scene.
        thick: Radius of an arrow on a node, of the size of the scene.
        shortest: Such radii in the length of an arrow that is drawn; shorter ones are specks.
        longest: Times the scale of forces: arrows of outliers end there.
        arrow: Of the size of the scene: how long the arrow of the scale of forces is.
        pull: The same of the largest resultant force.
        least: Of the largest resultant force: smaller ones have no arrow.
        edge: How far from the rim of the picture arrows end [px].
    """

    lamp: tuple[float, float, float] = (-0.45, 0.6, 0.75)
    gloss: float = 0.25
    shine: float = 0.15
    haze: float = 0.3
    fog: float = 0.62
    held: float = 0.75
    paler: float = 0.4
    unknown: float = 0.62
    lit: float = 0.84
    nearer: float = 1.2e-3
    pressed: float = 0.12
    dashes: float = 3.5
    inked: float = 0.6
    marker: float = 0.009
    marker_rest: float = 0.16
    opening: float = 0.3
    thick: float = 0.0022
    shortest: float = 3.0
    longest: float = 4.0
    arrow: float = 0.125
    pull: float = 0.18
    least: float = 0.005
    edge: float = 14.0


RULES = DrawingRules()


def shader_rules() -> str:
    """Return the rules as constants of a shader, in capitals."""
    lines: list[str] = []
    for name, value in asdict(RULES).items():
        kind, text = "float", repr(value)
        if isinstance(value, tuple):
            kind, text = "vec3", f"vec3{value!r}"
        lines.append(f"const {kind} {name.upper()} = {text};\n")
    return "".join(lines)


_MOST_DASHES = 24  # of a line


def rgb(text: str) -> Floats:
    """Return red, green and blue of ``#rrggbb``, dimensionless, from 0 to 1, shape (3,)."""
    return np.array([int(text[at : at + 2], 16) for at in (1, 3, 5)]) / 255.0


def ramp(colours: tuple[str, ...], value: Floats) -> Floats:
    """Return colours of dimensionless numbers from -1 to 1, shape (number, 3)."""
    table = np.array([rgb(text) for text in colours])
    place = np.linspace(-1.0, 1.0, len(table))
    return np.stack([np.interp(value, place, table[:, k]) for k in range(3)], axis=1)


def dashed(ends: Floats, dashes: Floats) -> tuple[Indices, Floats]:
    """Return lines cut into dashes.

    Args:
        ends: In any unit, shape (line, 2, 3).
        dashes: How many of them fit on each line; 0 for one that stays whole, shape (line,).

    Returns:
        The line of each dash, shape (dash,), and its ends, shape (dash, 2, 3).
    """
    count = np.clip(np.ceil(dashes), 1, _MOST_DASHES).astype(int)
    which = np.repeat(np.arange(len(ends)), count)
    size = np.where(dashes > 0.0, 1.0 / count, 1.0)[which]
    start = counted_up(count) * size
    stop = start + np.where(dashes > 0.0, RULES.inked, 1.0)[which] * size
    way = ends[which, 1] - ends[which, 0]
    places = (ends[which, 0] + part[:, None] * way for part in (start, stop))
    return which, np.stack(list(places), axis=1)
