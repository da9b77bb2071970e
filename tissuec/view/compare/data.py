"""A comparison as plain data for programs."""

from typing import Any

from tissuec.core.data import as_data
from tissuec.core.units import DIMENSION_NAMES
from tissuec.view.compare.comparison import Comparison
from tissuec.view.compare.curves import Curves
from tissuec.view.compare.events import EventComparison, EventEntry
from tissuec.view.compare.parameters import QuantityDifference
from tissuec.view.compare.places import SideParts
from tissuec.view.compare.sides import Side


def as_dict(found: Comparison) -> dict[str, Any]:
    """Return all numbers, in SI units."""
    return {
        "a": _side(found.a),
        "b": _side(found.b),
        "same": found.is_same,
        "texts": [as_data(one) for one in (*found.texts, *found.files)],
        "settings": [as_data(one) for one in found.settings],
        "common_nodes": len(found.nodes),
        "common_springs": len(found.springs),
        "leftovers": [as_data(one) for one in found.leftovers],
        "parameters": [_change(one) for one in found.changes],
        "events": _happened(found.logged_events),
        "provenance": [as_data(one) for one in found.provenance],
        "logs": None if found.curves is None else _curves_data(found.curves),
        "motion": _motion_data(found),
    }


def _side(side: Side) -> dict[str, Any]:
    run = side.trajectory
    kind = "scene" if run is None else "result"
    return {"file": side.name, "kind": kind, "scene": side.scene} | (
        {} if run is None else {"outcome": run.outcome, "finished": run.finished}
    )


def _change(change: QuantityDifference) -> dict[str, Any]:
    unit = None if change.dimension is None else DIMENSION_NAMES[change.dimension][1]
    return as_data(change) | {"dimension": unit}


def _happened(found: EventComparison | None) -> dict[str, Any] | None:
    if found is None:
        return None
    names = ("time", "kind", "cause")

    def plain(entry: EventEntry) -> dict[str, Any]:
        return {name: getattr(entry, name) for name in names}

    return {
        "same": found.is_same,
        "changed": [
            {"a": plain(m.a), "b": plain(m.b), "same_springs": m.a.springs == m.b.springs}
            for m in found.both
            if not m.is_same
        ],
        "only_a": [plain(entry) for entry in found.only_a],
        "only_b": [plain(entry) for entry in found.only_b],
    }


def _curves_data(curves: Curves) -> dict[str, Any]:
    both = [as_data(c) | {"relative": c.relative, "same": c.is_same} for c in curves.both]
    names = ("only_a", "only_b", "apart")
    return {"both": both, **{name: getattr(curves, name) for name in names}}


def _motion_data(found: Comparison) -> dict[str, Any] | None:
    motion = found.motion
    if motion is None or isinstance(motion, str):
        return None if motion is None else {"compared": False, "reason": motion}
    worst, names = motion.worst, ("tolerance_a", "tolerance_b", "nodes", "nodes_a", "nodes_b")
    return {
        "compared": True,
        "verdict": motion.verdict,
        "largest": motion.largest,
        "relative": float(motion.relative.max()),
        "time": float(motion.times[worst]),
        "node": SideParts(found.a).node(int(motion.node[worst])),
        "parting": motion.parting,
        "times": len(motion.times),
        "span_a": motion.span_a,
        "span_b": motion.span_b,
        "interpolated": motion.interpolated,
        "open": float(motion.open.max()),
        "whole": motion.is_whole,
        **{name: getattr(motion, name) for name in names},
    }
