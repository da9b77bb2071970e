"""Facts about a run as text on the page, and its playback speed."""

import re
from math import floor, log10
from typing import Any

from tissuec.core.data import printable
from tissuec.results.manifest import credits as credits_of
from tissuec.results.promise import stepping
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.film import PlayerData

_PACKAGES = ("tissuec", "python", "numpy", "scipy", "llvmlite")


def title(trajectory: Trajectory) -> str:
    """Return the title of the run: the name of its scene, or of its file."""
    scene = str(trajectory.manifest.get("scene") or "")
    name = re.split(r"[\\/]", scene)[-1].removesuffix(".tis")
    return name.replace("_", " ") or printable(trajectory.path.name)


def about(trajectory: Trajectory) -> str:
    """Return the description in the scene."""
    return str(trajectory.manifest.get("about") or "")


def author(trajectory: Trajectory) -> str:
    """Return the authors of the scene; empty if it does not name them."""
    return str(trajectory.manifest.get("author") or "")


def credits(trajectory: Trajectory) -> str:
    """Return authors, laboratory, licence and how to cite the scene, as far as it says so."""
    manifest = trajectory.manifest
    cite = f"cite as: {manifest['cite']}" if manifest.get("cite") else ""
    return " · ".join(filter(None, (credits_of(manifest), cite)))


def provenance(trajectory: Trajectory) -> str:
    """Return how the run was made: method, error, settings, outcome and versions."""
    manifest = trajectory.manifest
    network = trajectory.network
    parts = [
        str(network.size),
        stepping(manifest),
        f"accuracy in time: {trajectory.promise.sentence}",
        ", ".join(f"--set {text}" for text in manifest.get("overrides") or ()),
        "" if trajectory.finished else str(manifest.get("outcome") or "unfinished"),
        ", ".join(f"{name} {_version(manifest, name)}" for name in _PACKAGES
                  if _version(manifest, name)),
    ]  # fmt: skip
    return "; ".join(filter(None, parts))


def _version(manifest: dict[str, Any], name: str) -> str:
    versions: dict[str, Any] = manifest.get("versions") or {}
    return str(versions.get(name, ""))


def thinning(film: PlayerData) -> str:
    """Return which nodes are not drawn, as text; empty if all are drawn."""
    nodes, springs, edges = film.recorded
    if film.node_count == nodes:
        return ""
    lines = {"springs": springs, "edges of elements": edges}
    what = " and ".join(f"{number} {name}" for name, number in lines.items() if number)
    return (
        f"drawn: {film.node_count} of {nodes} nodes; {len(film.lines.ends)} lines represent "
        f"{what or '0 springs'}"
    )


_SHORTEST, _LONGEST, _USUAL = 1.5, 12.0, 6.0  # [s] of showing


def pace(duration: float) -> float:
    """Return how much simulated time passes in a second of showing.

    1 where that takes neither too long nor too little, otherwise the nearest of 1, 2, 5, 10, …
    """
    if _SHORTEST <= duration <= _LONGEST or not duration > 0.0:
        return 1.0
    return near(duration / _USUAL)


def near(value: float) -> float:
    """Return the nearest of …, 0.5, 1, 2, 5, 10, … to a number above zero."""
    power = 10.0 ** floor(log10(value))
    steps = (1.0, 2.0, 5.0, 10.0)
    return float(f"{min(steps, key=lambda step: abs(log10(step * power / value))) * power:.0e}")
