"""Long tables: a row for each node and time."""

from collections.abc import Sequence

import numpy as np

from tissuec.core.errors import counted
from tissuec.learn.data.complaints import first_few
from tissuec.learn.data.experiment import Series, nodes_of, owners
from tissuec.learn.data.rows import DataRows
from tissuec.model.network import Floats, Indices, Network
from tissuec.script.fit_problem import Fit

#: How the columns of a long table are written.
LONG = "node x y z"


def is_long(fit: Fit) -> bool:
    """Return whether a fit names a column of nodes."""
    return fit.measure is None and len(fit.columns) == len(LONG.split())


def read_long(fit: Fit, columns: Floats, rows: DataRows, network: Network) -> Series:
    """Return positions of nodes from a table with a row for each node and time.

    Rows of other nodes of the same bodies are ignored, and so are rows without a position.

    Args:
        fit: What is compared with data.
        columns: Ids of nodes and positions [m], shape (4, row).
        rows: The rows that count.
        network: The network.

    Raises:
        CompileError: A cell is no id, no node has the id, or a node has two rows at a time.
    """
    chosen = np.flatnonzero(~np.isnan(columns[1:]).all(axis=0))
    ids = _ids(fit, columns[0], chosen, rows)
    wanted = nodes_of(fit.subjects)
    number, known = _numbers(fit, ids, wanted, rows, network)
    _check_known(fit, ids[~known], rows, network)
    inside = number >= 0
    chosen, number = chosen[inside], number[inside]
    times, at = np.unique(rows.places[chosen], return_inverse=True)
    nodes, column = np.unique(number, return_inverse=True)
    place = at * len(nodes) + column
    _check_once(chosen, place, columns[0], rows)
    values = np.full((len(times) * len(nodes), 3), np.nan)
    values[place] = columns[1:, chosen].T
    return Series(fit, times, nodes, values.reshape(len(times), len(nodes), 3))


def _ids(fit: Fit, column: Floats, chosen: Indices, rows: DataRows) -> Indices:
    """Return the ids in some rows of a column, shape (chosen,)."""
    written = column[chosen]
    with np.errstate(invalid="ignore"):
        bad = np.flatnonzero(~(written == np.rint(written)) | (np.abs(written) > 2.0**53))
    if len(bad):
        value, row = written[bad[0]], int(rows.number[chosen[bad[0]]])
        problem = "no node" if np.isnan(value) else f"the node {value:g}, which is not an id"
        message = f"{rows.table.place(row)} has {problem}"
        hint = "ids of nodes are whole numbers"
        rows.complaints.reject("TIS313", message, fit.columns[0].span, hint)
    return written.astype(np.int64)


def _numbers(
    fit: Fit, ids: Indices, wanted: Indices, rows: DataRows, network: Network
) -> tuple[Indices, np.ndarray]:
    """Return numbers of the wanted nodes that ids mean, -1 of others, and which are ids at all.

    Both have shape (id,).
    """
    order = np.argsort(network.node_ids[wanted], kind="stable")
    listed = network.node_ids[wanted][order]
    twice = np.flatnonzero(np.diff(listed) == 0)
    if len(twice):
        names = " and ".join(body.name for body in owners(network, wanted))
        rows.complaints.reject(
            "TIS313",
            f"the id {listed[twice[0]]} belongs to several nodes of {fit.text}",
            fit.span,
            hint=f"fit the positions of {names} separately, from separate files",
        )
    place = np.minimum(np.searchsorted(listed, ids), len(listed) - 1)
    hit = listed[place] == ids
    every = [network.node_ids[body.nodes] for body in owners(network, wanted)]
    return np.where(hit, wanted[order][place], -1), np.isin(ids, np.concatenate(every))


def _check_known(fit: Fit, unknown: Indices, rows: DataRows, network: Network) -> None:
    if not len(unknown):
        return
    names = np.unique(unknown).astype(str).tolist()
    bodies = owners(network, nodes_of(fit.subjects))
    has = "; ".join(_range_of(body.name, network.node_ids[body.nodes]) for body in bodies)
    rows.complaints.reject(
        "TIS301",
        f"{rows.table.file} contains {counted(len(names), 'node')} that "
        f"{' and '.join(body.name for body in bodies)} does not have: "
        f"{', '.join(first_few(names))}",
        fit.columns[0].span,
        hint=has,
    )


def _range_of(name: str, ids: Sequence[int] | Indices) -> str:
    return f"ids of {name} run from {min(ids)} to {max(ids)}"


def _check_once(chosen: Indices, place: Indices, ids: Floats, rows: DataRows) -> None:
    """Check that no node has two rows at a time."""
    order = np.argsort(place, kind="stable")
    twice = np.flatnonzero(np.diff(place[order]) == 0)
    if len(twice):
        row, other = chosen[order[twice[0]]], chosen[order[twice[0] + 1]]
        rows.reject_twice(int(row), int(other), f"node {ids[row]:g}")
