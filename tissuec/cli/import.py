"""``tissuec import``: Show the contents of a mesh file, as a scene to start from."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from tissuec.cli.common import DONE, Command, Settings, echo, print_json
from tissuec.core import units
from tissuec.core.errors import TissueError, counted
from tissuec.core.fields import LocatedFile

if TYPE_CHECKING:
    from tissuec.meshes.repair import RepairedMesh

_MOST_GROUPS = 20  # that are listed in a scene; --json has all of them
_CELLS_ACROSS = 8  # of a proposed filling, along the shortest side

SCENE = """\
language 1
about "An organ from {name}."
{facts}
use "tissues/liver"

body organ {{
  mesh is imported {{
    file "{name}" in {unit}
{filling}  }}
  tissue is liver
{regions}}}
set bottom = nodes of organ where z < {bottom}

environment {{ gravity = (0, 0, -9.81) m/s^2; damping = 1 mN*s/m }}
script {{ at 0 s: fix bottom }}
simulate {{ duration = 20 ms }}
output {{ trajectory every 5 ms }}
"""


@click.command("import", cls=Command)
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--unit",
    default="mm",
    help="Unit of the coordinates, which the file does not contain [mm].",
)
def command(settings: Settings, file: Path, unit: str) -> int:
    """Show the contents of the mesh file FILE, as a scene to start from.

    Counts, extents, groups and defects are comments at the top of the scene. To create a scene
    that runs:

    \b
    tissuec import liver.stl --unit mm > liver.tis
    """
    from tissuec.meshes.generators.imported import Imported, MeshFileError

    mesh = Imported(LocatedFile(file.name, file, _factor(unit)))
    try:
        shape = mesh.shape
    except MeshFileError as error:
        raise TissueError(str(error) + (f"; {error.hint}" if error.hint else "")) from error
    scene = _scene(shape, file.name, unit)
    _warn_of_size(shape)
    if settings.json:
        print_json({**_facts(shape), "file": str(file), "unit": unit, "scene": scene})
    else:
        click.echo(scene, nl=False)
    return DONE


def _warn_of_size(shape: "RepairedMesh") -> None:
    """Say on stderr that a mesh is hardly that of an organ: perhaps the unit is another."""
    from tissuec.scene.usual_ranges import USUAL

    size, usual = float(np.ptp(shape.position, axis=0).max()), USUAL["size"]
    if not usual.holds(size):
        shown = units.show(size, units.LENGTH)
        echo(
            f"warning: the mesh is {shown} large, outside of the usual range: {usual.shown}; "
            "is --unit right?",
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


def _facts(shape: "RepairedMesh") -> dict[str, Any]:
    """Return what is in a mesh file, repaired, in SI units."""
    from tissuec.geometry.edges import Edges, volume

    is_closed = Edges.among(shape.skin).is_closed
    return {
        "nodes": len(shape.position),
        "triangles": len(shape.skin),
        "tetrahedra": len(shape.tetrahedra),
        "other_cells": shape.others,
        "low": shape.position.min(axis=0),
        "high": shape.position.max(axis=0),
        "closed": is_closed,
        "volume": volume(shape.position, shape.skin) if is_closed else None,
        "groups": {name: len(nodes) for name, nodes in shape.groups.items()},
        "defects": list(shape.remarks),
    }


def _scene(shape: "RepairedMesh", name: str, unit: str) -> str:
    low, high = shape.position.min(axis=0), shape.position.max(axis=0)
    facts = _facts(shape)
    filling = ""
    if facts["closed"] and not shape.is_volume:
        cell = _rounded(float((high - low).min()) / _CELLS_ACROSS)
        filling = f"    filling is sodium chloride; cell = {cell}; reach is second neighbours\n"
    groups = list(shape.groups)[:_MOST_GROUPS]
    regions = "".join(
        f'  # region part {k} where group is "{group}" {{ tissue is … }}\n'
        for k, group in enumerate(groups, 1)
    )
    regions += "  # interface is mean\n" if regions else ""
    bottom = units.show(float(low[2] + 0.1 * (high[2] - low[2])), units.LENGTH)
    if not high[2] > low[2]:
        bottom = units.show(float(low[2]) + 1e-6, units.LENGTH)
    return SCENE.format(
        name=name,
        facts="\n".join(f"# {line}" for line in _lines(facts, unit)),
        unit=unit,
        filling=filling,
        regions=regions,
        bottom=bottom,
    )


def _lines(facts: dict[str, Any], unit: str) -> Iterator[str]:
    """Yield what is in a file, in words."""
    parts = [
        counted(facts["nodes"], "node"),
        f"a surface of {counted(facts['triangles'], 'triangle')}",
    ]
    if facts["tetrahedra"] or facts["other_cells"]:
        parts.append(f"{facts['tetrahedra']} tetrahedra and {facts['other_cells']} other cells")
    yield ", ".join(parts)
    closed = "it is not closed"
    if facts["closed"]:
        closed = f"it is closed and encloses {1e6 * facts['volume']:.4g} ml"
    yield f"in {unit}, {closed}, and"
    for axis, low, high in zip("xyz", facts["low"], facts["high"], strict=True):
        ends = (units.show(float(value), units.LENGTH) for value in (low, high))
        yield f"  {axis} runs from {' to '.join(ends)}"
    for name, count in list(facts["groups"].items())[:_MOST_GROUPS]:
        yield f'group "{name}": {counted(count, "node")}'
    if (more := len(facts["groups"]) - _MOST_GROUPS) > 0:
        yield f"and {more} further groups"
    for remark in facts["defects"]:
        yield re.sub(r"\s+", " ", remark)


def _rounded(length: float) -> str:
    """Return a length with one digit that counts, as a scene has it."""
    digit = 10.0 ** np.floor(np.log10(length))
    return units.show(float(np.floor(length / digit) * digit), units.LENGTH)
