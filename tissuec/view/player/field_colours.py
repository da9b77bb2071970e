"""The colours of a field; see ``web/shared.glsl``."""

import numpy as np

from tissuec.core import palette
from tissuec.model.network import Floats
from tissuec.view.player.node_values import FieldValues
from tissuec.view.player.rules import RULES
from tissuec.view.player.strokes import ramp


def field_colours(values: FieldValues, numbers: Floats) -> Floats:
    """Return the colours of numbers of a field, from 0 to 1, shape (…, 3).

    Args:
        values: The field.
        numbers: In its unit, NaN where it is unknown, shape (…).
    """
    part = np.clip((numbers - values.low) / (values.high - values.low), 0.0, 1.0)
    known = np.isfinite(part)
    found = ramp(shades_of(values), 2.0 * np.where(known, part, 0.0).ravel() - 1.0)
    return np.where(known[..., None], found.reshape(*numbers.shape, 3), RULES.unknown)


def between_rows(values: FieldValues, at: float) -> Floats:
    """Return the numbers at a moment, in the unit of the field, shape (node,).

    Args:
        values: The field.
        at: Moment, in rows of the film.
    """
    first = int(at)
    second, part = min(first + 1, len(values.value) - 1), at - first
    return (1.0 - part) * values.value[first] + part * values.value[second]


def readable(colour: Floats, normal: Floats, to_eye: Floats) -> Floats:
    """Return colours with so little shade that they can be compared, shape (…, 3).

    Args:
        colour: From 0 to 1, shape (…, 3).
        normal: Of one unit, as the camera sees it, shape (…, 3).
        to_eye: Direction to the eye, shape (…, 3).
    """
    facing = np.abs((normal * to_eye).sum(axis=-1, keepdims=True))
    return np.asarray(colour * (RULES.lit + (1.0 - RULES.lit) * facing), dtype=float)


def shades_of(values: FieldValues) -> tuple[str, ...]:
    """Return the colours between which the numbers of a field lie, the lowest first."""
    return palette.TENSION if values.is_signed else palette.AMOUNT
