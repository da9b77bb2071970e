"""How a run was stepped, in words."""

from collections.abc import Mapping
from typing import Any

from tissuec.core.errors import counted
from tissuec.core.units import TIME, show


def methods(statistics: Mapping[str, Any]) -> str:
    """Return the methods in turn, such as "dop853, esdirk43 from 2.14 ms on"."""
    first, *others = statistics["changes"] or [statistics]
    later = (f", {one['method']} from {show(one['time'], TIME)} on" for one in others)
    return first["method"] + "".join(later)


def stepping(manifest: Mapping[str, Any]) -> str:
    """Return how a run was stepped and how long that took; the method if no more is known."""
    statistics = manifest.get("statistics")
    if not statistics:
        return str(manifest.get("method") or manifest.get("integrator") or "")
    code, threads = statistics["backend"], statistics.get("threads", 1)
    code = code if threads == 1 else f"{code}, {threads} threads"
    steps = counted(statistics["accepted"], "step")
    return f"{methods(statistics)}, {steps} ({code}), {manifest['wall_time']:.2f} s"
