"""Fields as pages contain them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.view.player.drawn_nodes import DrawnNodes
from tissuec.view.player.fields import TISSUE
from tissuec.view.player.node_values import FieldValues, read_fields
from tissuec.view.player.packing import Pack, Quantization

_FINE = 1000  # steps of the range of colours
_LEVELS = 65533  # of all numbers; one more number means unknown


def pack_fields(
    nodes: DrawnNodes, chosen: FieldValues | None, pack: Pack, scale: Quantization
) -> dict[str, Any]:
    """Put fields into a pack, and return what pages have to know of them.

    Args:
        nodes: Of the film.
        chosen: The field that is shown first; None for the tissues.
        pack: Takes the arrays.
        scale: The steps of positions.
    """
    pack.add("home", scale.steps(nodes.drawn).T[None])
    return {
        "fields": [_described(values, pack) for values in read_fields(nodes, chosen)],
        "field": TISSUE if chosen is None else chosen.field.name,
        "noStress": nodes.unknown_stress,
    }


def _described(values: FieldValues, pack: Pack) -> dict[str, Any]:
    field, step = values.field, 0.0
    if not field.derived:
        numbers, step = levels(values)
        pack.add(f"field {field.name}", numbers)
    return {
        "name": field.name,
        "about": field.text,
        "shown": (float(f"1e{values.scale.power}"), values.scale.unit),
        "range": (values.low, values.high),
        "usual": values.usual,
        "extent": (values.least, values.most),
        "step": step,
    }


def levels(values: FieldValues) -> tuple[NDArray[np.int64], float]:
    """Return values as whole numbers of steps, shape (row, node), and the step in their unit.

    The least number is 1, and unknown ones are 0. A thousandth of the range of colours is a
    step, unless there would be too many.
    """
    size = max(abs(values.low), abs(values.high))
    step = max(size / _FINE, (values.most - values.least) / _LEVELS)
    steps = np.where(np.isnan(values.value), -1.0, (values.value - values.least) / step)
    return np.rint(steps).astype(np.int64) + 1, step
