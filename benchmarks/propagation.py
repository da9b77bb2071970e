"""The published propagation on the published tube, against the length of its frames.

Takes some minutes. The scene is sterilisation of the library until before the cut, without
ruptures: the tube hangs, is grasped and lifted. What it is measured by is the same scene to a
tolerance of 1e-8. The JSON document has the errors of velocity Verlet, too;
docs/make_propagation.py draws it.
"""

import tempfile
from pathlib import Path
from typing import Any

import click
import numpy as np
from msgspec import Struct

from benchmarks.publishing import json_option, publish, tell, write_option
from tissuec.core.data import as_data
from tissuec.core.markdown import table
from tissuec.core.resources import library
from tissuec.core.source import Source
from tissuec.core.units import TIME, show
from tissuec.pipeline import compile_request, simulate
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request

DURATION = 0.6
FRAMES = (50e-3, 20e-3, 10e-3, 5e-3, 2e-3, 1e-3, 0.5e-3, 0.2e-3, 0.1e-3)
METHOD = "integrator is automatic; tolerance = 1e-4"
#: How the publication may be read, and what it is compared with.
METHODS = {
    "forces remembered": "propagation",
    "forgotten at each frame": "propagation { former force is forgotten }",
    "velocity verlet": "velocity verlet",
}


class Measured(Struct, frozen=True):
    """A run with frames, or steps, of one length.

    Attributes:
        frame: t_Δ, or the step [s].
        evaluations, stalls: What it took.
        error: Of positions, over the largest displacement; infinite if it diverged.
        added: Energy from nowhere at the end, over the largest of the exact run.
    """

    frame: float
    evaluations: int
    stalls: int
    error: float
    added: float


@click.command(help=__doc__)
@write_option
@json_option
def main(*, write: bool, as_json: bool) -> None:
    """Measure everything."""
    exact, _ = positions(scene("integrator is dop853; tolerance = 1e-8"))
    found = {
        name: [measured(method, frame, exact) for frame in FRAMES]
        for name, method in METHODS.items()
    }
    document = {name: [as_data(run) for run in runs] for name, runs in found.items()}
    tables = {"propagation": shown(found)}
    publish("propagation", tables, write=write, document=document if as_json else None)


def scene(method: str) -> str:
    """Return the text of the scene with another method."""
    text = (library() / "scenes" / "sterilisation.tis").read_text(encoding="utf-8")
    kept = [
        line
        for line in text.splitlines()
        if not line.startswith("expect")
        and not any(word in line for word in ("cut time", "facing", "release", "gap of"))
    ]
    changed = "\n".join(kept).replace("rupture is allowed", "rupture is not allowed")
    changed = changed.replace("tool shears { kind is scissors }\n", "")
    changed = changed.replace("duration = 2 s", f"duration = {DURATION} s")
    changed = changed.replace("force of forceps A every 1 ms", "")
    changed = changed.replace("every 40 ms", "every 50 ms").replace(
        "every 10 ms", "every 50 ms"
    )
    return changed.replace(METHOD, method)


def positions(text: str) -> tuple[tuple[np.ndarray, np.ndarray], dict[str, Any]]:
    """Return positions [m] and energies [J] over time, and the manifest."""
    request = Request(Source("propagation.tis", text))
    compiled, _ = compile_request(request)
    with tempfile.TemporaryDirectory() as folder:
        path = simulate(compiled, Path(folder) / "run.vtkhdf", request=request).path
        with Trajectory.open(path) as trajectory:
            energies = trajectory.energies
            assert energies is not None
            state = np.asarray(trajectory.position), np.asarray(energies.value)
            return state, trajectory.manifest


def measured(method: str, frame: float, exact: tuple[np.ndarray, np.ndarray]) -> Measured:
    """Return what a run with frames, or steps, of a size does."""
    state, manifest = positions(scene(f"integrator is {method}; step = {frame!r} s"))
    position, energy = state
    done = bool(manifest["finished"])
    reach = np.linalg.norm(exact[0] - exact[0][0], axis=2).max()
    error = np.linalg.norm(position - exact[0], axis=2).max() / reach if done else np.inf
    kinetic, elastic, weight, work, lost, switched = energy.T
    balance = kinetic + elastic + weight - work + lost - switched
    largest = (exact[1][:, 0] + exact[1][:, 1]).max()
    added = (balance[-1] - balance[0]) / largest if done else np.inf
    statistics = manifest["statistics"]
    tell(f"{frame:g} s: {manifest['outcome']}, error {error:.2g}, added {added:.2g}")
    return Measured(
        frame,
        int(statistics["evaluations"]),
        int(statistics["stalls"]),
        float(error),
        float(added),
    )


def shown(found: dict[str, list[Measured]]) -> str:
    """Return the table of the page."""
    first, second, _ = found
    heads = (
        "t_Δ", f"{first}: error", "energy added", "forces per frame", "stalls per frame",
        f"{second}: error", "energy added",
    )  # fmt: skip
    rows: list[tuple[str, ...]] = []
    for one, other in zip(found[first], found[second], strict=True):
        frames = DURATION / one.frame
        work = (f"{one.evaluations / frames:.0f}", f"{one.stalls / frames:.0f}")
        done = (*ended(one), *(work if np.isfinite(one.error) else ("", "")))
        rows.append((show(one.frame, TIME), *done, *ended(other)))
    return table(heads, rows)


def ended(run: Measured) -> tuple[str, str]:
    """Return the error and the energy of a run, in words."""
    if not np.isfinite(run.error):
        return "diverged", ""
    return f"{run.error:.1e}", f"{100.0 * run.added:+.2g} %"


if __name__ == "__main__":
    main()
