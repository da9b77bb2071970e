"""Contents of a page: arrays, which are quantised and deflated, fields, and names of nodes.

An array is rounded to whole steps of a stated size, replaced by its differences from frame to
frame, of the order that deflates best, and written low bytes first. What the page reads back is
wrong by half a step at most.
"""

import base64
import zlib
from typing import Any

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from tissuec.model.network import Indices
from tissuec.view.player.drawn_nodes import DrawnNodes
from tissuec.view.player.fields import TISSUE
from tissuec.view.player.node_values import FieldValues, read_fields
from tissuec.view.player.tints import written_tissue

ORDERS = (0, 1, 2)
_FINE = 65535  # steps
_FAR = 4.0  # sizes of a usual frame: what moves further does not set the steps
_TRIED = 1 << 22  # numbers: of larger arrays, a part is tried to find the order
_THOROUGH = 1 << 24  # bytes: more of them are deflated quickly


class Pack(Struct):
    """Arrays one after the other, and the place of each.

    Attributes:
        specs: By name, what a reader must know: "shape", "order", "bytes" of a number, and
            "from", where it begins among all bytes; numbers are "low" + what is written.
    """

    specs: dict[str, dict[str, Any]] = field(default_factory=dict[str, dict[str, Any]])
    _parts: list[bytes] = field(default_factory=list[bytes])
    _size: int = 0

    def add(self, name: str, numbers: NDArray[Any]) -> None:
        """Add whole numbers, dimensionless, of shape (frame, …).

        They pack best if they change little between frames.
        """
        shape = np.shape(numbers)
        rows = np.asarray(numbers).reshape(shape[0], int(np.prod(shape[1:])))
        low = int(rows.min()) if rows.size else 0
        wide = (rows.astype(np.int64) - low).astype(np.uint32)
        width = 1 if not rows.size or wide.max() < 1 << 8 else 2 if wide.max() < 1 << 16 else 4
        order = best_order(wide, width)
        data = to_bytes(wide, order, width)
        self.specs[name] = {
            "shape": list(shape),
            "low": low,
            "order": order,
            "bytes": width,
            "from": self._size,
        }
        self._parts.append(data)
        self._size += len(data)

    def packed(self) -> str:
        """Return everything as text: raw DEFLATE in base64."""
        quick = self._size > _THOROUGH
        worker = zlib.compressobj(4 if quick else 9, zlib.DEFLATED, -zlib.MAX_WBITS)
        parts = [worker.compress(part) for part in self._parts]
        return base64.b64encode(b"".join([*parts, worker.flush()])).decode()


def best_order(rows: NDArray[np.uint32], width: int) -> int:
    """Return the order of differences that deflates best.

    Args:
        rows: Numbers, shape (frame, number).
        width: Bytes of a number.
    """
    few = rows[: max(4, _TRIED // max(1, rows.shape[1]))]
    orders = ORDERS[: max(1, len(few))]
    sizes = [len(zlib.compress(to_bytes(few, order, width), 1)) for order in orders]
    return int(np.argmin(sizes))


def to_bytes(rows: NDArray[np.uint32], order: int, width: int) -> bytes:
    """Return differences, the lowest bytes of all numbers first.

    Differences may be negative, so that they are taken modulo 2^(8 width) and folded: 0, -1, 1,
    -2, … become 0, 1, 2, 3, …

    Args:
        rows: Numbers, shape (frame, number).
        order: Order of the differences.
        width: Bytes of a number.
    """
    bits = 8 * width
    kind = np.dtype(f"u{width}")
    steps = rows.astype(kind)
    for _ in range(order):
        steps = np.diff(steps, axis=0, prepend=np.zeros((1, rows.shape[1]), dtype=kind))
    sign = (steps >> kind.type(bits - 1)).astype(kind)
    folded = (steps << kind.type(1)) ^ (kind.type(0) - sign)
    planes = folded.reshape(-1).astype(f"<u{width}").view(np.uint8).reshape(-1, width)
    return np.ascontiguousarray(planes.T).tobytes()


class Quantization(Struct, frozen=True):
    """Meaning of whole numbers: ``origin + step * number``, for each of the last axis."""

    origin: tuple[float, ...]
    step: float

    def steps(self, values: NDArray[Any]) -> NDArray[np.int64]:
        """Return values as whole numbers of steps, in the shape of ``values``.

        Args:
            values: In the unit of ``step``.
        """
        return np.rint((values - np.array(self.origin)) / self.step).astype(np.int64)


def box_scale(position: NDArray[Any]) -> Quantization:
    """Return a scale that divides the largest side of all frames into 65535 steps.

    Where something flies far away, that of a usual frame: it does not spoil the net.

    Args:
        position: [m], shape (frame, point, 3).
    """
    low, high = position.min(axis=1), position.max(axis=1)
    size = float(np.median((high - low).max(axis=1)))
    far = float((high.max(axis=0) - low.min(axis=0)).max())
    usual = far if far < _FAR * size or not size else size
    step = max(usual / _FINE, far / 2**31) or 1.0  # half of all numbers of four bytes, at most
    return Quantization(tuple(map(float, low.min(axis=0))), step)


def even(values: NDArray[Any], most: float, steps: int) -> NDArray[np.int64]:
    """Return values from -most to most as whole numbers from -steps to steps.

    Outliers are clipped.

    Args:
        values: In any unit, of any shape.
        most: Largest value, in the same unit.
        steps: Largest whole number.
    """
    return np.rint(np.clip(values / (most or 1.0), -1.0, 1.0) * steps).astype(np.int64)


_COLOURS = 1000  # steps of the range of colours
_LEVELS = 65533  # of all numbers; one more number means unknown


def pack_fields(
    nodes: DrawnNodes, chosen: FieldValues | None, pack: Pack, scale: Quantization
) -> dict[str, Any]:
    """Put fields into a pack, and return what pages have to know of them.

    Args:
        nodes: Of the film.
        chosen: The field that is shown first; None for the tissues.
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
        **({"decades": values.decades} if values.decades else {}),
        **({"isLog": True} if values.logarithmic else {}),
        "extent": (values.least, values.most),
        "step": step,
    }


def levels(values: FieldValues) -> tuple[NDArray[np.int64], float]:
    """Return values as whole numbers of steps, shape (row, node), and the step in their unit.

    The least number is 1, and unknown ones are 0. A thousandth of the range of colours is a
    step, or of logarithmic colours a tenth of their low end, unless there would be too many.
    """
    size = max(abs(values.low), abs(values.high))
    size = 0.1 * _COLOURS * values.low if values.logarithmic else size
    step = max(size / _COLOURS, (values.most - values.least) / _LEVELS)
    steps = np.where(np.isnan(values.value), -1.0, (values.value - values.least) / step)
    return np.rint(steps).astype(np.int64) + 1, step


def pack_node_facts(nodes: DrawnNodes, pack: Pack) -> dict[str, Any]:
    """Put ids and regions of nodes into a pack, and return the names of bodies and regions.

    Args:
        nodes: Of the film.
    """
    trajectory, numbers = nodes.trajectory, nodes.film.numbers
    groups = [one for one in trajectory.groups if one.body and one.what == "nodes"]
    region: Indices = np.zeros(trajectory.network.node_count, dtype=np.int64)
    for number, group in enumerate(groups, start=1):
        region[group.indices] = number
    count = trajectory.network.node_count
    is_node, of = numbers < count, nodes.representatives
    pack.add("ids", np.where(is_node, trajectory.network.node_ids[of], -1)[None])
    pack.add("region", region[of][None])
    return {
        "bodies": [
            {
                "name": body.name,
                "from": int(np.searchsorted(numbers, int(body.nodes.start))),
                "tissue": str(written_tissue(trajectory, body.name).get("name", "")),
            }
            for body in trajectory.network.bodies
        ],
        "regions": [
            {
                "name": one.name,
                "tissue": str(written_tissue(trajectory, one.body, one.name).get("name", "")),
            }
            for one in groups
        ],
    }
