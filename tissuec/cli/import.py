"""``tissuec import``: Show the contents of a mesh file, as a scene to start from."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from tissuec.cli.common import Command, Settings, echo
from tissuec.core import resources, units
from tissuec.core.errors import TissueError, counted
from tissuec.core.fields import LocatedFile
from tissuec.core.hints import nearby_file
from tissuec.core.report import Report, Verbatim

if TYPE_CHECKING:
    from tissuec.meshes.generators.imported import Imported
    from tissuec.meshes.repair import RepairedMesh
    from tissuec.model.network import Floats

_MOST_GROUPS = 20  # that are listed in a scene; --json has all of them
_MOST_HOLES = 5  # whose places are listed
#: A proposed filling has about so many nodes and never more than ten times as many, and at the
#: least so many cells across the mean thickness, 2 V / A of volume and surface. Tetrahedra also
#: have nodes between their corners, so that they count as two along each side.
_NODES, _CELLS_ACROSS = 4000, 1.5
_CUBES = 2000  # of a label image: its equilibrium takes about 14 s
_MOST_SITES = 2_000_000  # of the lattice in the box around a body, of which some are taken

_SHORT = 3.0  # [s]: runs that take longer, with their start, are announced

SHORT = "duration = 20 ms"
SOLID = "duration = 1 s; integrator is equilibrium; step = 1 s"
SCENE = """\
language 1
about "An organ from {name}."
{facts}
use "{preset}/liver"

body organ {{
  mesh is imported {{
    file "{name}" in {unit}
{part}{filling}  }}
  tissue is liver
{regions}}}
set bottom = nodes of organ where z < {bottom}

environment {{ gravity = (0, 0, -9.81) m/s^2{damping} }}
script {{ at 0 s: fix bottom }}
simulate {{ {times} }}
output {{ trajectory every {every} }}
"""


@click.command("import", cls=Command)
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--unit",
    default="mm",
    help="Unit of the coordinates, which the file does not contain [mm].",
)
def command(settings: Settings, file: Path, unit: str) -> Report:
    """Show the contents of the mesh file FILE, as a scene to start from.

    Counts, extents, groups and defects are comments at the top of the scene. To create a scene
    that runs:

    \b
    tissuec import liver.stl --unit mm > liver.tis
    """
    from tissuec.meshes.generators.imported import Imported, MeshFileError
    from tissuec.meshes.images import is_image

    mesh = Imported(LocatedFile(str(file), file, _factor(unit)))
    try:
        if is_image(file):
            mesh = _of_cubes(mesh)
        shape = mesh.shape
    except MeshFileError as error:
        hint = f"write: --unit {error.unit}" if error.unit else error.hint or _elsewhere(file)
        raise TissueError(f"{error}; {hint}" if hint else str(error)) from error
    facts = {**_facts(mesh, shape), **_image_facts(mesh)}
    filling = _filling(mesh, facts)
    scene = _scene(facts, filling, file.name, unit)
    _warn_of_size(facts, unit)
    seconds = _predicted_seconds(scene, file) if SOLID in scene else None
    if seconds is not None and seconds > _SHORT:
        shown = units.show(seconds, units.TIME, digits=2)
        echo(
            f"note: the run of this scene takes about {shown} of processor time, without the "
            "companion run",
            err=True,
        )
    document = {**facts, "file": str(file), "unit": unit, "scene": scene, "seconds": seconds}
    return Report([Verbatim(scene)], document)


def _predicted_seconds(scene: str, file: Path) -> float | None:
    """Return the processor time of the proposed run [s]; None where it cannot be compiled."""
    from tissuec.compiler.prediction import predict
    from tissuec.core.source import Source
    from tissuec.pipeline import compile_request
    from tissuec.scene.request import Request

    try:
        compiled, _ = compile_request(Request(Source("", scene, file.parent / "scene.tis")))
    except TissueError:
        return None
    return predict(compiled).seconds


def _elsewhere(file: Path) -> str:
    """Return which other file may be meant, of the library or of a similar name, or ""."""
    if file.exists():
        return ""
    if (resources.library() / "meshes" / f"{file.stem}.obj").exists():
        return f"to copy the mesh of the library: tissuec library copy meshes/{file.stem}"
    return nearby_file(file, file.suffix)


def _warn_of_size(facts: dict[str, Any], unit: str) -> None:
    """Say on stderr that a mesh is hardly that of an organ, and in which unit it would be."""
    from tissuec.scene.usual_ranges import USUAL

    size, usual = float((facts["high"] - facts["low"]).max()), USUAL["size"]
    if usual.holds(size):
        return
    low, high = usual.typical
    sizes = {other: size / _factor(unit) * _factor(other) for other in usual.units}
    better = next((other for other, found in sizes.items() if low <= found <= high), None)
    hint = "is --unit right?"
    if better is not None:
        large = units.show(sizes[better], units.LENGTH)
        hint = f"if it is {large} large, write: --unit {better}"
    shown = units.show(size, units.LENGTH)
    echo(
        f"warning: the mesh is {shown} large, outside of the usual range: {usual.shown}; "
        f"{hint}",
        err=True,
    )


def _factor(unit: str) -> float:
    try:
        found = units.parse_unit(unit)
    except units.UnitError as error:
        raise click.UsageError(str(error)) from error
    if found.dimension != units.LENGTH:
        raise click.UsageError(f'"{unit}" is not a unit of length')
    return found.factor


def _facts(mesh: "Imported", shape: "RepairedMesh") -> dict[str, Any]:
    """Return the contents of a repaired mesh file, in SI units."""
    from tissuec.geometry.edges import Edges, volume
    from tissuec.meshes.generators.imported import CUBES

    elements, divided = dict[str, int](), 0
    if mesh.filling != CUBES:
        elements, divided = mesh.divided_cells()

    edges = Edges.among(shape.skin)
    holes: list[dict[str, Any]] = []
    for nodes in edges.holes()[:_MOST_HOLES]:
        around = shape.position[nodes]
        centre, size = around.mean(axis=0), float(np.ptp(around, axis=0).max())
        holes.append({"nodes": len(nodes), "centre": centre, "size": size})
    return {
        "nodes": len(shape.position),
        "triangles": len(shape.skin),
        "elements": dict(elements),
        "quality": _quality(shape),
        "divided_cells": divided,
        "left_out": dict(shape.ignored),
        "low": shape.position.min(axis=0),
        "high": shape.position.max(axis=0),
        "closed": edges.is_closed,
        "volume": volume(shape.position, shape.skin) if edges.is_closed else None,
        "holes": holes,
        "parts": list(shape.parts),
        "groups": {name: len(nodes) for name, nodes in shape.groups.items()},
        "defects": list(shape.remarks),
    }


def _quality(shape: "RepairedMesh") -> dict[str, float] | None:
    """Return the worst and the mean quality of tetrahedra; None of files with other cells."""
    from tissuec.meshes.slivers import worst_and_mean

    if not len(shape.tetrahedra) or shape.divided:
        return None
    worst, mean = worst_and_mean(shape.position, shape.tetrahedra)
    return {"worst": worst, "mean": mean}


def _of_cubes(mesh: "Imported") -> "Imported":
    """Return the lattice that is proposed for a label image."""
    from tissuec.meshes.generators.imported import CUBES, Imported

    image = mesh.image
    cell = (image.volume(image.values_of(None)) / _CUBES) ** (1 / 3)
    return Imported(mesh.file, filling=CUBES, cell=_read(_rounded(cell)))


def _image_facts(mesh: "Imported") -> dict[str, Any]:
    """Return the numbers of voxels of a label image and their size [m]; none of meshes."""
    from tissuec.meshes.generators.imported import CUBES

    if mesh.filling != CUBES:
        return {}
    image = mesh.image
    return {"voxels": image.labels.shape, "voxel": np.linalg.norm(image.axes, axis=0)}


def _filling(mesh: "Imported", facts: dict[str, Any]) -> tuple[str, str]:
    """Return the entries of a filling that can be built, and a remark on it."""
    from tissuec.meshes.generators.imported import CUBES, TETRAHEDRA, Imported, MeshFileError
    from tissuec.meshes.stiffness_sharing import node_areas

    shape = mesh.shape
    if mesh.filling == CUBES and mesh.cell is not None:
        return f"    filling is {CUBES}; cell = {units.show(mesh.cell, units.LENGTH)}\n", ""
    if not facts["closed"] or shape.is_volume or not facts["volume"] > 0.0:
        return "", ""
    enclosed, area = facts["volume"], float(node_areas(shape.position, shape.skin).sum())
    extents: Floats = facts["high"] - facts["low"]
    box = float(np.prod(extents))
    least = (max(enclosed / (10 * _NODES), box / _MOST_SITES)) ** (1 / 3)
    cell = max(2.0 * enclosed / area / _CELLS_ACROSS, (8.0 * enclosed / _NODES) ** (1 / 3))
    while cell >= least:
        written = _rounded(cell)
        try:
            filled = Imported(mesh.file, filling=TETRAHEDRA, cell=_read(written))
            built = filled.build_elements()
        except MeshFileError:
            cell /= 1.5
            continue
        (elements,) = built.elements
        size = f"{counted(len(built.position), 'node')} and {len(elements.nodes)} tetrahedra"
        if len(built.position) > 10 * _NODES + len(shape.position):
            break
        return f"    filling is {TETRAHEDRA}; cell = {written}\n", f"filled: {size}"
    return "", (
        f"its walls are thin ({units.show(2 * enclosed / area, units.LENGTH)} on average): a "
        "filling would need too many nodes; it is taken as a surface"
    )


def _scene(facts: dict[str, Any], filling: tuple[str, str], name: str, unit: str) -> str:
    low, high = facts["low"], facts["high"]
    regions = "".join(
        f'  # region part {k} where group is "{group}" {{ tissue is … }}\n'
        for k, group in enumerate(list(facts["groups"])[:_MOST_GROUPS], 1)
    )
    parts = facts["parts"]
    part = f'    # part "{parts[0]}"  # for this part of the file alone\n' if parts[1:] else ""
    bottom = units.show(float(low[2] + 0.1 * (high[2] - low[2])), units.LENGTH, digits=9)
    if not high[2] > low[2]:
        bottom = units.show(float(low[2]) + 1e-6, units.LENGTH, digits=9)
    lines = [*_lines(facts, unit), *([filling[1]] if filling[1] else [])]
    # A surface has no thickness to be a wall of matter with.
    is_solid = bool(filling[0] or facts["elements"])
    return SCENE.format(
        preset="matter" if is_solid else "tissues",
        damping="" if is_solid else "; damping = 1 mN*s/m",
        # Steps of nearly incompressible solids are so short that their motion takes minutes.
        times=SOLID if is_solid else SHORT,
        every="1 s" if is_solid else "5 ms",
        name=name,
        facts="\n".join(f"# {line}" for line in lines),
        unit=unit,
        part=part,
        filling=filling[0],
        regions=regions,
        bottom=bottom,
    )


def _lines(facts: dict[str, Any], unit: str) -> Iterator[str]:
    """Yield lines of text that describe the contents of a file."""
    if "voxels" in facts:
        sides = " x ".join(units.show(float(side), units.LENGTH) for side in facts["voxel"])
        voxels = " x ".join(map(str, facts["voxels"]))
        yield f"{voxels} voxels of {sides}; in cubes:"
    parts = [
        counted(facts["nodes"], "node"),
        f"a surface of {counted(facts['triangles'], 'triangle')}",
    ]
    parts += [counted(many, shape) for shape, many in facts["elements"].items() if many]
    if cells := facts["divided_cells"]:
        parts[-1] += f" ({counted(cells, 'other cell')} divided)"
    left_out = [f"{counted(many, kind)} left out" for kind, many in facts["left_out"].items()]
    yield ", ".join([*parts, *left_out])
    if facts["quality"]:
        worst, mean = facts["quality"]["worst"], facts["quality"]["mean"]
        yield f"quality of tetrahedra: {worst:.2g} at worst, {mean:.2g} on average"
    closed = "it is not closed"
    if facts["closed"]:
        closed = f"it is closed and encloses {1e6 * facts['volume']:.4g} ml"
    yield f"in {unit}, {closed}, and"
    for axis, low, high in zip("xyz", facts["low"], facts["high"], strict=True):
        ends = (units.show(float(value), units.LENGTH) for value in (low, high))
        yield f"  {axis} runs from {' to '.join(ends)}"
    for hole in facts["holes"]:
        centre = ", ".join(units.show(float(value), units.LENGTH) for value in hole["centre"])
        across = units.show(hole["size"], units.LENGTH)
        yield f"a hole of {hole['nodes']} edges around ({centre}), {across} across"
    for name, count in list(facts["groups"].items())[:_MOST_GROUPS]:
        kind = "part" if name in facts["parts"] else "group"
        yield f'{kind} "{name}": {counted(count, "node")}'
    if (more := len(facts["groups"]) - _MOST_GROUPS) > 0:
        yield f"and {more} further groups"
    for remark in facts["defects"]:
        if remark in left_out:
            continue
        yield re.sub(r"\s+", " ", remark)


def _read(length: str) -> float:
    number, unit = length.split()
    return float(number) * _factor(unit)


def _rounded(length: float) -> str:
    """Return a length with two digits that count, as a scene has it."""
    digit = 10.0 ** (np.floor(np.log10(length)) - 1.0)
    return units.show(float(np.floor(length / digit) * digit), units.LENGTH)
