"""A result as one HTML document that plays it, without network access or other files."""

import html
import json
import re
from collections.abc import Mapping
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissuec.core import palette
from tissuec.core.data import as_data
from tissuec.core.prefixes import shown_units
from tissuec.core.scale import AxisUnit, readable
from tissuec.core.version import __version__
from tissuec.model.network import Floats
from tissuec.results.instruments.meshes import mesh_of
from tissuec.results.trajectory import Trajectory
from tissuec.view.player import facts
from tissuec.view.player.camera import ANGLE, MARGIN, framing
from tissuec.view.player.cells import MOST_NODES
from tissuec.view.player.curves import LogCurve, first_pair, marks, read_curves, read_quantities
from tissuec.view.player.drawn_nodes import DrawnNodes
from tissuec.view.player.facts import pace
from tissuec.view.player.files import still
from tissuec.view.player.film import PlayerData, SurfacePiece
from tissuec.view.player.lifetimes import FOREVER
from tissuec.view.player.node_values import FieldValues, chosen_field
from tissuec.view.player.options import DEFAULT, Options
from tissuec.view.player.packing import Pack, box_scale, even, pack_fields, pack_node_facts
from tissuec.view.player.reading import read_film
from tissuec.view.player.rules import RULES, shader_rules
from tissuec.view.plots.projection import viewpoint

WEB = Path(__file__).resolve().parent / "web"
#: Parts of the script, in order.
SCRIPTS = (
    "arrays.js", "units.js", "camera.js", "meshes.js", "graphics.js", "normals.js",
    "fields.js", "sections.js", "cap.js", "instruments.js", "haste.js", "target.js",
    "lines.js", "skin.js", "stage.js", "flat.js", "marks.js", "placing.js", "pulls.js",
    "curves.js", "pairs.js", "panel.js", "legend.js", "cutting.js", "sight.js",
    "picks.js", "hands.js", "player.js",
)  # fmt: skip
#: What only readers of the source need: indents and comments.
_LAYOUT = re.compile(r"^ +(?://.*\n)?|^//.*\n|^/\*.*\*/\n|^\n|  // .*$", re.MULTILINE)
#: Breaks of lines inside of statements and blocks, in scripts, shaders and styles.
_BREAKS = re.compile(r"(?<=[;{,(\[])\n|\n(?=[}\])])")
#: Spaces that style sheets do without.
_SPACES = re.compile(r"(?<=[:;,{]) | (?=\{)")
SHADERS = ("shared", "lines", "skin", "section", "solids", "instruments", "arrows", "plane")
_TENSIONS, _FORCES = 127, 2000  # steps of the scale, either way
_FRAGMENT = "// ---- fragment\n"
_RULES = "// ---- rules\n"
_LEVELS = 65534  # of a curve; one more number means none
_PULL = 2**30  # steps of resultant forces, either way: their numbers are exact
_MESH = 1e-3  # steps of the meshes of instruments, in their units
_STEPS = {
    "tension": _TENSIONS, "force": _FORCES / RULES.longest, "level": _LEVELS, "pull": _PULL,
    "mesh": _MESH,
}  # fmt: skip


def render(trajectory: Trajectory, options: Options = DEFAULT) -> str:
    """Return the whole HTML document.

    Raises:
        TissueError: The result has no frame to show.
    """
    return render_film(read_film(trajectory, options), trajectory, options)


def render_film(film: PlayerData, trajectory: Trajectory, options: Options = DEFAULT) -> str:
    """Return the document for the drawable contents of a result."""
    pack, nodes = Pack(), DrawnNodes(film, trajectory)
    field = chosen_field(nodes, options)
    described = describe(nodes, field, options, pack)
    return Template(_web("shell.html")).substitute(
        title=html.escape(facts.title(trajectory)),
        about=html.escape(facts.about(trajectory)),
        author=html.escape(facts.author(trajectory)),
        credits=html.escape(facts.credits(trajectory)),
        still=still(film, options, field),
        version=html.escape(__version__),
        style=Template(_style()).substitute(_colours()),
        film=as_script(described | {"arrays": pack.specs}),
        arrays=pack.packed(),
        script=_joined(_compact("\n".join(map(_web, SCRIPTS)))),
    )


def fragment(trajectory: Trajectory, options: Options = DEFAULT, *, height: int = 640) -> str:
    """Return the player as an element to be put into another page.

    It has a frame of its own, so that the styles and keys of the pages do not interfere.

    Args:
        height: Of the frame [px].

    Raises:
        TissueError: The result has no frame to show.
    """
    name = html.escape(facts.title(trajectory))
    document = html.escape(render(trajectory, options))
    style = f"width:100%;height:{height}px;border:0"
    return f'<iframe title="player of {name}" style="{style}" srcdoc="{document}"></iframe>'


def as_script(value: object) -> str:
    """Return plain data as JSON that no HTML parser mistakes for the end of a script."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    for letter in "<>&\u2028\u2029":
        text = text.replace(letter, f"\\u{ord(letter):04x}")
    return text


def describe(
    nodes: DrawnNodes, field: FieldValues | None, options: Options, pack: Pack
) -> dict[str, Any]:
    """Put arrays into ``pack``, and return everything else that the page needs.

    Args:
        nodes: Of a film, with its result.
        field: What colours the skin at first; its tissues if None.
    """
    film, trajectory = nodes.film, nodes.trajectory
    scale = box_scale(film.position)
    # A step of velocities is a step of positions from one frame to the next.
    rate = scale.step / (float(np.diff(film.times).max(initial=0.0)) or 1.0)
    most = {
        "tension": film.most_tension, "strain": film.most_strain, "force": film.most_force,
        "pull": film.most_resultant,
    }  # fmt: skip
    _pack_shapes(film, pack)
    pack.add("position", scale.steps(film.position).transpose(0, 2, 1))
    velocity = film.velocity * film.is_curved[:, None, None] / rate
    pack.add("velocity", np.rint(velocity).astype(np.int64).transpose(0, 2, 1))
    pack.add("tension", even(film.lines.tension, most["tension"], _TENSIONS))
    _pack_forces(film, pack, most)
    for name, most_of in _largest(film).items():
        pack.add(name, even(getattr(film.lines, name), most_of, _LEVELS)[None])
    duration = float(film.times[-1] - film.times[0])
    return {
        "title": facts.title(trajectory),
        "made": facts.provenance(trajectory),
        "thinned": facts.thinning(film),
        "finished": trajectory.finished,
        "times": film.times.tolist(),
        "sides": np.flatnonzero(film.is_side).tolist(),
        "nodes": film.node_count,
        **{"rate": rate, "origin": scale.origin, "step": scale.step},
        **{"most": most, "steps": _STEPS, "largest": _largest(film)},
        "laws": film.laws,
        **_tools(film, pack),
        "surfaces": _surfaces(film, pack, scale.step),
        "units": {unit: units_of(unit) for unit in ("m", "N")},
        "clock": _shown(trajectory.clock),
        **_pairs(trajectory),
        "curves": [_curve(one, k, pack) for k, one in enumerate(read_curves(trajectory))],
        "marks": _marks(trajectory, duration),
        "view": _view(film, options),
        "colour": options.colour or "tension",
        **pack_fields(nodes, field, pack, scale),
        **pack_node_facts(nodes, pack),
        "springs": film.shows_springs(options.colour),
        "divisions": film.divisions,
        **_section(film, options),
        "start": float(film.times[0] if options.time is None else options.time),
        "pace": options.speed or pace(duration),
        "looks": _looks(),
        "rules": as_data(RULES),
        "shaders": {name: _shader(name) for name in SHADERS},
    }


def _largest(film: PlayerData) -> dict[str, float]:
    """Return the ends of the scales of what springs have all the time [m]."""
    return {
        "rest": float(film.lines.rest.max(initial=0.0)),
        "radius": float(film.lines.radius.max(initial=0.0)),
    }


def _pack_shapes(film: PlayerData, pack: Pack) -> None:
    """Put what is drawn into ``pack``: which nodes, and in which frames."""
    cells = film.cells.sorted
    for name, numbers in (
        ("ends", film.lines.ends.T),
        ("law", film.lines.law[None]),
        ("stitch", film.lines.stitch[None].astype(int)),
        ("triangles", film.skin.triangles.T),
        ("smooth", film.skin.smooth[None].astype(int)),
        ("hollow", film.skin.hollow[None].astype(int)),
        ("tints", np.rint(255.0 * film.tints).astype(np.int64).reshape(1, -1)),
        ("dots", film.dots.of[None]),
        ("held", film.held.rods.T),
        ("cells", cells.tetrahedra),
        ("tissue", film.tissue[None]),
        ("curved", film.curved[None].astype(int)),
    ):
        pack.add(name, numbers)
    lives = {
        "lines": film.lines.life,
        "skin": film.skin.life,
        "cells": cells.life,
        "dots": film.dots.life,
        "held": film.held.life,
        "patches": film.held.patches,
    }
    if len(film.held.rims):
        pack.add("rims", film.held.rims.T)
        lives["rims"] = film.held.rim_life
    for name, life in lives.items():
        pack.add(f"life of {name}", _frames(life))


def _pack_forces(film: PlayerData, pack: Pack, most: Mapping[str, float]) -> None:
    """Put forces on nodes and resultant forces into ``pack``, in parts of the largest ones."""
    none = np.zeros((len(film.times), 0, 3))
    pulls = np.concatenate([none, *(one.force[:, None] for one in film.resultants)], axis=1)
    pack.add("pulls", even(pulls, most["pull"], _PULL).transpose(0, 2, 1))
    # Arrows of outliers are longer; beyond that they would leave the picture.
    pack.add(
        "force", even(film.force, RULES.longest * most["force"], _FORCES).transpose(0, 2, 1)
    )


def _marks(trajectory: Trajectory, duration: float) -> list[Any]:
    """Return the events, as marks on the timeline."""
    found = marks(trajectory.events, duration, trajectory.network)
    return [as_data(mark) for mark in found]


def _tools(film: PlayerData, pack: Pack) -> dict[str, Any]:
    """Describe tools and what they do, and pack the meshes of instruments."""
    return {
        "solids": [as_data(solid) for solid in film.solids],
        "instruments": [as_data(instrument) for instrument in film.instruments],
        "meshes": _meshes(film, pack),
        "pulls": [
            {
                "name": one.name,
                "point": one.point,
                "life": one.life,
                "shown": _shown(one.scale),
            }
            for one in film.resultants
        ],
    }


def _meshes(film: PlayerData, pack: Pack) -> dict[str, float]:
    """Pack the meshes of instruments, and return their pivots by kind."""
    found = {one.kind: mesh_of(one.kind) for one in film.instruments}
    for kind, mesh in found.items():
        pack.add(f"mesh {kind}", np.rint(mesh.vertices.T / _MESH).astype(np.int64)[None])
        pack.add(f"mesh {kind} parts", mesh.part[None])
        pack.add(f"mesh {kind} triangles", mesh.triangles.T)
    return {kind: mesh.pivot for kind, mesh in found.items()}


def _frames(life: NDArray[Any]) -> NDArray[np.int64]:
    """Return lives in thousandths of frames, beginnings before ends, shape (2, life)."""
    return np.rint(np.minimum(life, FOREVER / 1e3) * 1e3).astype(np.int64).T


def _view(film: PlayerData, options: Options) -> dict[str, Any]:
    frame = framing(film)
    azimuth, elevation = options.view or viewpoint(frame.points)
    return {
        "points": [[float(f"{value:.10g}") for value in point] for point in frame.points],
        "middle": frame.middle.tolist() if frame.follows else [],
        "size": frame.size,
        "azimuth": azimuth,
        "elevation": elevation,
        "angle": ANGLE,
        "margin": MARGIN,
    }


def _surfaces(film: PlayerData, pack: Pack, step: float) -> list[dict[str, Any]]:
    """Pack smooth surfaces in the steps of the net."""
    found: list[dict[str, Any]] = []
    for number, (name, pieces) in enumerate(film.surfaces.items()):
        parts = [_piece(piece, f"surface {number} {part}", pack, step)
                 for part, piece in enumerate(pieces)]  # fmt: skip
        found.append({"name": name, "pieces": parts})
    return found


def _piece(piece: SurfacePiece, name: str, pack: Pack, step: float) -> dict[str, Any]:
    origin = piece.position.min(axis=(0, 1)).tolist() if piece.position.size else [0.0] * 3
    numbers = np.rint((piece.position - np.array(origin)) / step).astype(np.int64)
    pack.add(f"{name} position", numbers.transpose(0, 2, 1))
    pack.add(f"{name} triangles", piece.triangles.T)
    return {
        "name": name,
        "origin": origin,
        "frames": piece.frames.tolist(),
        "tint": piece.tint.tolist(),
    }


def _shown(scale: AxisUnit) -> tuple[float, str]:
    """Return the divisor of numbers in the SI unit, and the unit of the quotients."""
    return float(f"1e{scale.power}"), scale.unit


def units_of(unit: str) -> list[tuple[float, str]]:
    """Return sizes and names of units for lengths and forces that depend on the view."""
    return [(one.size, readable(one.unit)) for one in shown_units(unit)]


def _section(film: PlayerData, options: Options) -> dict[str, Any]:
    """Describe the section that is shown first, and bodies that it cannot cap."""
    plane, left_out = options.section, film.cells.left_out
    verb = "has" if len(left_out) == 1 else "have"
    said = f"{', '.join(left_out)} {verb} more than {MOST_NODES} nodes: open without a cut face"
    return {
        "section": plane and as_data(plane) | {"axis": plane.axis},
        "tissues": film.tissues,
        "uncapped": said if left_out else "",
    }


def _pairs(trajectory: Trajectory) -> dict[str, Any]:
    """Describe what the menus of the chart of two quantities offer and show first."""
    quantities = read_quantities(trajectory)
    return {
        "quantities": [
            {
                "name": one.name, "curve": one.curve, "columns": one.columns,
                "from": one.is_displacement, "shown": _shown(one.scale),
            }
            for one in quantities
        ],
        "pair": first_pair(quantities),
    }  # fmt: skip


def _curve(curve: LogCurve, number: int, pack: Pack) -> dict[str, Any]:
    finite = curve.value[np.isfinite(curve.value)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    step = (high - low) / _LEVELS or 1.0
    with np.errstate(invalid="ignore"):
        levels = np.where(
            np.isfinite(curve.value), np.rint((curve.value - low) / step) + 1.0, 0.0
        )
    pack.add(f"curve {number}", levels.astype(np.int64))
    return {
        "name": curve.name,
        "shown": _shown(curve.scale),
        "columns": curve.columns,
        "leftOut": curve.left_out,
        "clock": _clock(curve.time, number, pack),
        "low": low,
        "high": high,
        "step": step,
        "empty": not finite.size,
    }


def _clock(time: Floats, number: int, pack: Pack) -> dict[str, float]:
    """Pack the times of a curve, and return their scale; they are as fine as nine digits."""
    first = float(time[0]) if len(time) else 0.0
    step = (float(time[-1]) - first) / 2**30 if len(time) else 0.0
    pack.add(f"clock {number}", np.rint((time - first) / (step or 1.0)).astype(np.int64))
    return {"first": first, "step": step or 1.0}


def _compact(text: str) -> str:
    return _LAYOUT.sub("", text)


def _joined(text: str) -> str:
    return _BREAKS.sub("", text)


def _style() -> str:
    return _SPACES.sub("", _joined(_compact(_web("player.css"))))


def _shader(name: str) -> str:
    # "// ---- fragment" divides it, so that this comment stays.
    parts = _web(f"{name}.glsl").replace(_RULES, shader_rules()).split(_FRAGMENT)
    return _FRAGMENT.join(_joined(_compact(part)) for part in parts)


def _web(name: str) -> str:
    return (WEB / name).read_text(encoding="utf-8")


def _colours() -> dict[str, str]:
    """Return the colours of the style sheet."""
    return _looks() | {
        "accent": palette.SERIES[0],
        "accent_dark": palette.SERIES[4],
        "force": palette.SERIES[2],
    }  # fmt: skip


def _looks() -> dict[str, Any]:
    """Return the colours that all pictures share."""
    names = [name for name in vars(palette) if name.isupper()]
    return {name.lower(): getattr(palette, name) for name in names}
