"""The film between two of its frames."""

from typing import Any

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from tissuec.model.network import Floats
from tissuec.view.player.film import PlayerData, SurfacePiece


class InterpolatedFrame(Struct, frozen=True, eq=False):
    """A film between two of its frames.

    Attributes:
        at: In frames.
        position: Of all points [m], shape (point, 3).
        force: On nodes [N], shape (node, 3).
        tension: Of lines [N], shape (line,).
        strain: Of lines, shape (line,).
    """

    at: float
    position: Floats
    force: Floats
    tension: Floats
    strain: Floats

    @classmethod
    def of(cls, film: PlayerData, at: float) -> "InterpolatedFrame":
        """Return the content of a film at a number of frames."""
        first = int(at)
        second, part = min(first + 1, len(film.times) - 1), at - first

        def between(numbers: NDArray[Any]) -> Floats:
            return (1.0 - part) * numbers[first] + part * numbers[second]

        position = position_at(film, at)
        ends, rest = film.lines.ends, film.lines.rest
        length = np.linalg.norm(position[ends[:, 1]] - position[ends[:, 0]], axis=1)
        stretch = length / np.where(rest > 0.0, rest, np.inf) - 1.0
        strain = np.where(rest > 0.0, stretch, 0.0)
        return cls(at, position, between(film.force), between(film.lines.tension), strain)


def position_at(film: PlayerData, at: float) -> Floats:
    """Return the positions of all points at a number of frames [m], shape (point, 3).

    Between two frames they follow the cubic through the positions and velocities of both, or
    a straight line where the motion is too fast for that.
    """
    first = int(at)
    second, part = min(first + 1, len(film.times) - 1), at - first
    straight = (1.0 - part) * film.position[first] + part * film.position[second]
    if first == second or not film.curved[first]:
        return straight
    step = float(film.times[second] - film.times[first])
    way = film.position[second] - film.position[first]
    begin, end = step * film.velocity[first : second + 1].astype(float)
    left = 1.0 - part
    return straight + part * left * (left * (begin - way) + part * (way - end))


def surface_at(pieces: list[SurfacePiece], at: float) -> tuple[SurfacePiece, Floats]:
    """Return the visible piece of a smooth surface, and its points [m], shape (point, 3).

    Args:
        pieces: The pieces.
        at: Moment, in frames.
    """
    piece = [one for one in pieces if one.frames[0] <= at + 1e-6 or one is pieces[0]][-1]
    place = float(np.interp(at, piece.frames, np.arange(len(piece.frames))))
    first = int(place)
    second = min(first + 1, len(piece.frames) - 1)
    part = place - first
    return piece, (1.0 - part) * piece.position[first] + part * piece.position[second]
