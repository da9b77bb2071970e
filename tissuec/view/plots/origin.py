"""Nodes of a result by names and sets, as a scene has them."""

from typing import TYPE_CHECKING

import numpy as np

from tissuec.core.errors import TissueError
from tissuec.core.source import Source
from tissuec.lang import syntax as s
from tissuec.model.network import Indices
from tissuec.results.names import NODES, members

if TYPE_CHECKING:
    from tissuec.compiler.compile import Compiled
    from tissuec.results.trajectory import Trajectory

_SETS = ("nodes of ", "springs of ", "[")


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
        from tissuec.analysis.result_scene import recompile

        recompiled = recompile(trajectory)
        if recompiled.compiled is None:
            reasons = "; ".join(doubt.text for doubt in recompiled.doubts)
            raise TissueError(f'the sets of "{trajectory.path}" are unknown: {reasons}')
        return _chosen(recompiled.compiled, asked)
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
