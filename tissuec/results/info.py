"""The facts of a result file that ``tissuec info`` prints."""

from collections import Counter
from typing import Any

from tissuec.results.surface_table import SurfaceSeries
from tissuec.results.tables import Log
from tissuec.results.trajectory import Trajectory


def summary(trajectory: Trajectory) -> dict[str, Any]:
    """Return a summary of a result file, from its JSON facts."""
    times, network, manifest = trajectory.times, trajectory.network, trajectory.manifest
    checkpoint = trajectory.checkpoint()
    energies = trajectory.energies
    return {
        "file": str(trajectory.path),
        "bytes": trajectory.path.stat().st_size,
        "outcome": trajectory.outcome,
        "finished": trajectory.finished,
        "promise": str(trajectory.promise),
        "doubts": [str(doubt) for doubt in trajectory.doubts],
        "without_effect": [str(one) for one in trajectory.without_effect],
        "network": {
            **network.size.facts,
            "bodies": [body.name for body in network.bodies],
            **({"joints": [joint.name for joint in network.joints]} if network.joints else {}),
        },
        "frames": {
            "count": len(times),
            "nodes": len(trajectory.nodes),
            "springs": len(trajectory.springs),
            "precision": "single" if trajectory.position.dtype.itemsize == 4 else "double",
            "compressed": trajectory.is_compressed,
            "fields": [channel.name for channel in trajectory.channels],
            **_span(times),
        },
        "logs": {name: _log(log) for name, log in trajectory.logs.items()},
        "surfaces": {name: _surface(one) for name, one in trajectory.surfaces.items()},
        "energies": _log(energies) if energies is not None else None,
        "events": dict(Counter(event.kind for event in trajectory.events)),
        "can_resume": checkpoint is not None and not trajectory.finished,
        **{
            name: manifest.get(name)
            for name in ("method", "plan", "overrides", "digest", "wall_time", "statistics")
        },
        "versions": manifest["versions"],
    }


def _log(log: Log) -> dict[str, Any]:
    return {
        "rows": len(log.time),
        "jumps": len(log.jumps.time),
        "columns": list(log.columns),
        "unit": log.unit,
        **_span(log.time),
    }


def _surface(series: SurfaceSeries) -> dict[str, Any]:
    return {
        "count": len(series),
        "kind": series.kind,
        **series.entries,
        **_span(series.times),
    }


def _span(times: Any) -> dict[str, float | None]:
    """Return the first and the last time [s]; None where there is none."""
    first, last = (float(times[0]), float(times[-1])) if len(times) else (None, None)
    return {"first_time": first, "last_time": last}
