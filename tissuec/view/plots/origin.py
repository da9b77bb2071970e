"""The scene that a result came from, compiled once more for its names: sets, bodies, tools."""

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tissuec.core.errors import CompileError, TissueError
from tissuec.core.source import Source
from tissuec.lang import syntax as s
from tissuec.model.network import Indices
from tissuec.results.names import NODES, members

if TYPE_CHECKING:
    from tissuec.compiler.compile import Compiled
    from tissuec.results.trajectory import Trajectory

_SETS = ("nodes of ", "springs of ", "[")


def origin_of(trajectory: "Trajectory") -> "Compiled":
    """Return the scene of a result, compiled.

    Raises:
        TissueError: It is not what it was when it ran, such as where a mesh file has changed.
    """
    from tissuec.compiler.compile import compile_scene
    from tissuec.scene.findings import Findings
    from tissuec.scene.imports import load
    from tissuec.scene.resolve import resolve

    manifest, findings = trajectory.manifest, Findings()
    with tempfile.TemporaryDirectory() as folder:
        _unpack(manifest.get("sources", {}), Path(folder))
        source = Source(str(manifest["scene"]), trajectory.text, _place_of(trajectory))
        try:
            program = load(source, (Path(folder),), findings)
            compiled = compile_scene(
                resolve(program, findings, manifest["overrides"]), findings
            )
        except CompileError as error:
            raise TissueError(
                f'the scene of "{trajectory.path}" can no longer be compiled: '
                f"{error.diagnostics[0].message}"
            ) from error
    _check_same(trajectory, compiled)
    return compiled


def _unpack(sources: dict[str, str], folder: Path) -> None:
    """Write out what the scene used, whatever has become of those files since."""
    for name, text in sources.items():
        place = folder / name
        if folder.resolve() in place.resolve().parents:
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_text(text, encoding="utf-8")


def _place_of(trajectory: "Trajectory") -> Path:
    """Return where the scene stands, or stood: files that it names are looked for beside it."""
    written = Path(str(trajectory.manifest["scene"]))
    beside = trajectory.path.parent / written.name
    return beside if beside.is_file() and not written.is_file() else written


def _check_same(trajectory: "Trajectory", compiled: "Compiled") -> None:
    """Check that numbers of nodes and springs mean what they meant in the run."""
    now, then = compiled.network, trajectory.network
    names = ("position", "ends", "node_ids", "spring_ids")
    if not all(np.array_equal(getattr(now, name), getattr(then, name)) for name in names):
        raise TissueError(
            f'the scene of "{trajectory.path}" now gives another net than in the run, so its '
            "sets are unknown; run it again"
        )


def nodes_of(trajectory: "Trajectory", asked: str) -> Indices:
    """Return the nodes of a name or set, as network numbers, shape (n,).

    Args:
        trajectory: The result.
        asked: A name of a set or body, a region with its body, or a set in the language, such
            as "nodes of vessel where x < 1 mm".

    Raises:
        TissueError: There is no such name, or the scene has changed.
        CompileError: The set has an error.
    """
    if s.key_of(asked).startswith(_SETS):
        return _chosen(origin_of(trajectory), asked)
    try:
        return members(trajectory.network, trajectory.groups, asked, NODES)
    except ValueError as error:
        like = f'"nodes of {next(iter(trajectory.bodies), "BODY")} where x < 1 mm"'
        raise TissueError(f"{error}; or write a set, such as {like}") from error


def _chosen(compiled: "Compiled", text: str) -> Indices:
    """Return the nodes of a set that no scene has."""
    from tissuec.lang.parser import parse
    from tissuec.scene.declarations import Declared

    groups, found = compiled.groups, np.zeros(0, dtype=np.int64)
    (item,) = parse(Source("--of", f"set plotted = {text}"), has_heading=False).items
    assert isinstance(item, s.Assign)
    groups.declared[item.name.key] = Declared(item.name, item)
    with groups.findings.item():
        found = groups.nodes(item.name).indices
    groups.findings.raise_errors()
    return found


def recorded(trajectory: "Trajectory", nodes: Indices) -> Indices:
    """Return the rows of the frames that show nodes, shape (m,).

    Nodes that are not recorded are left out.

    Args:
        trajectory: The result.
        nodes: Network numbers, shape (n,).
    """
    if not len(trajectory.nodes):
        return np.zeros(0, dtype=np.int64)
    rows = np.minimum(np.searchsorted(trajectory.nodes, nodes), len(trajectory.nodes) - 1)
    return rows[trajectory.nodes[rows] == nodes]
