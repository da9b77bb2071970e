"""Which way shafts of instruments lead: out of the tissue, which they do not hide."""

import numpy as np

from tissuec.core.vectors import directions
from tissuec.model.network import Floats

_TRIED = 72  # directions in the plane
_SPREAD = 200  # directions in space
_ALONG = 1e-3  # part of a direction at right angles to another below which it leads along it
_UP = np.array([0.0, 0.0, 1.0])


def shaft_across(
    axis: Floats, foot: Floats, tissue: Floats, wanted: Floats | None = None
) -> Floats:
    """Return a unit vector at right angles to an axis that leads out of tissue, upwards.

    Args:
        axis: Unit vector, shape (3,).
        foot: Where the instrument works [m], shape (3,).
        tissue: Nodes around it [m], shape (node, 3).
        wanted: Where it leads as far as it can, shape (3,).
    """
    if wanted is not None:
        aside = wanted - (wanted @ axis) * axis
        if float(np.linalg.norm(aside)) > _ALONG:
            return aside / np.linalg.norm(aside)
    turn = np.linspace(0.0, 2.0 * np.pi, _TRIED, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    tried = np.asarray(circle @ frame_along(axis)[:2], dtype=float)
    return tried[int(np.argmax(_merit(tried, foot, tissue)))]


def frame_along(shaft: Floats) -> Floats:
    """Return unit vectors x, y and z, of which z is the given one, shape (3, 3)."""
    side = np.eye(3)[int(np.abs(shaft).argmin())]
    x = np.cross(side, shaft)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(shaft, x), shaft])


def free_shaft(foot: Floats, tissue: Floats) -> Floats:
    """Return a unit vector that leads out of tissue, upwards, shape (3,).

    Args:
        foot: Where the instrument works [m], shape (3,).
        tissue: Nodes around it [m], shape (node, 3).
    """
    tried = directions(_SPREAD)
    return tried[int(np.argmax(_merit(tried, foot, tissue)))]


def _merit(tried: Floats, foot: Floats, tissue: Floats) -> Floats:
    """Return how well directions suit: up, away from the middle, and through no tissue."""
    away = foot - tissue.mean(axis=0)
    size = float(np.linalg.norm(np.ptp(tissue, axis=0))) or 1.0
    ways = (tissue - foot) / size
    far = np.linalg.norm(ways, axis=1)
    ways = ways[far > 0.02] / far[far > 0.02, None]
    # How many nodes stand within 25 degrees of each direction.
    blocked = (tried @ ways.T > 0.906).mean(axis=1) if len(ways) else np.zeros(len(tried))
    return tried @ (_UP + 1.5 * away / size) - 4.0 * np.sqrt(blocked)
