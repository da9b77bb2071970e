"""Results of tissuec as data: frames of nodes, and logs."""

from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from tissuec.core.errors import counted
from tissuec.core.hints import alternatives
from tissuec.learn.data.complaints import Complaints, first_few
from tissuec.learn.data.experiment import Series
from tissuec.learn.data.logged import as_measured, find_log, is_position, title_of
from tissuec.learn.data.nodes import nodes_of, owners
from tissuec.learn.data.thinning import nearest_rows
from tissuec.model.network import Floats, Indices, Network
from tissuec.results.trajectory import Trajectory
from tissuec.script.fit_problem import Fit


def read_result(
    fit: Fit, result: Trajectory, network: Network, complaints: Complaints
) -> Series:
    """Return the series of a fit in a result.

    Positions are those of the frames. Anything else is that of the log of its name; where a
    position has none, it is the mean of the frames.

    Args:
        fit: What is compared with data.
        result: The result.
        network: The network.
        complaints: Takes errors in the data.

    Raises:
        CompileError: There is no such log, or the frames do not show the nodes.
    """
    if fit.measure is None:
        return _positions(fit, result, network, complaints)
    name = find_log(fit, result.logs)
    if name is None and is_position(fit):
        series = _positions(fit, result, network, complaints)
        assert series.nodes is not None
        missing = len(nodes_of(fit.subjects)) - len(series.nodes)
        if missing:
            _reject_hidden(fit, missing, result, complaints)
        return Series(fit, series.times, None, as_measured(fit, series.values.mean(axis=1)))
    if name is None:
        title = title_of(fit)
        complaints.reject(
            "TIS301",
            f'{complaints.file} has no log "{title}"',
            fit.span,
            hint=alternatives(title, first_few(list(result.logs)), what="its logs")
            or f"write in the scene of that run: output {{ {title} every 1 ms }}",
        )
    log = result.logs[name]
    rows = _once(log.time)
    rows = rows[nearest_rows(log.time[rows], fit.every)]
    return Series(fit, log.time[rows], None, as_measured(fit, log.value[rows]))


def _once(times: Floats) -> Indices:
    """Return the rows of different times: of those of one time the last, after any event."""
    return np.flatnonzero(np.diff(times, append=np.inf) > 0.0)


def _positions(
    fit: Fit, result: Trajectory, network: Network, complaints: Complaints
) -> Series:
    """Return the places of those nodes that the frames show."""
    nodes = nodes_of(fit.subjects)
    theirs = _in_result(nodes, network, result.network)
    shown = np.isin(theirs, result.nodes) & (theirs >= 0)
    if not shown.any():
        _reject_hidden(fit, len(nodes), result, complaints)
    rows = _once(result.times)
    rows = rows[nearest_rows(result.times[rows], fit.every)]
    columns = np.searchsorted(result.nodes, theirs[shown])
    values = np.asarray(result.position[rows][:, columns], dtype=float)
    return Series(fit, result.times[rows], nodes[shown], values)


def _in_result(nodes: Indices, network: Network, other: Network) -> Indices:
    """Return the numbers that nodes have in another network, by body and id, or -1.

    The other one may have been drawn more finely, or have bodies that this one has not.
    """
    found = np.full(len(nodes), -1)
    bodies = {body.name: body.nodes for body in other.bodies}
    for body in owners(network, nodes):
        if body.name not in bodies:
            continue
        own = np.flatnonzero(_within(nodes, body.nodes))
        ids = other.node_ids[bodies[body.name]]
        order = np.argsort(ids, kind="stable")
        wanted = network.node_ids[nodes[own]]
        place = np.minimum(np.searchsorted(ids[order], wanted), len(ids) - 1)
        number = bodies[body.name].start + order[place]
        found[own] = np.where(ids[order][place] == wanted, number, -1)
    return found


def _reject_hidden(
    fit: Fit, missing: int, result: Trajectory, complaints: Complaints
) -> NoReturn:
    """Raise that frames do not show so many nodes of a fit."""
    bodies = result.network.bodies
    counts = {body.name: int(_within(result.nodes, body.nodes).sum()) for body in bodies}
    shown = [f"{counted(count, 'node')} of {name}" for name, count in counts.items() if count]
    names = ", ".join(one.name for one in fit.subjects)
    complaints.reject(
        "TIS301",
        f"the frames of {complaints.file} do not contain {missing} of "
        f"{len(nodes_of(fit.subjects))} nodes of {names}",
        fit.span,
        hint=f"they contain {', '.join(shown)}" if shown else "they contain no nodes of bodies",
    )


def _within(nodes: Indices, part: slice) -> NDArray[np.bool_]:
    return (nodes >= part.start) & (nodes < part.stop)
