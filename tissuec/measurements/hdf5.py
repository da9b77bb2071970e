"""Data from HDF5 files: results with their logs, and H5MD files of other programs.

Of results, frames and logs are read; of H5MD files, positions of particles and observables. In
H5MD files, numbers without a unit are in SI units. (P. de Buyl, P. H. Colberg, F. Höfling,
Comput. Phys. Commun. 185:1546, 2014.)
"""

import re
from collections.abc import Callable, Iterable, Sequence
from typing import NoReturn, TypeVar

import numpy as np
from numpy.typing import NDArray

from tissuec.core.errors import counted
from tissuec.core.hints import alternatives
from tissuec.core.units import LENGTH, TIME, Dimension, Unit, UnitError, describe, parse_unit
from tissuec.measurements.experiment import Series, nodes_of, owners
from tissuec.measurements.rows import Complaints, first_few, nearest_rows
from tissuec.model.network import Floats, Indices, Network, numbers_in
from tissuec.results import ForeignFileError, ResultError, access
from tissuec.results.access import Dataset, ResultGroup
from tissuec.results.hdf5 import open_file
from tissuec.results.trajectory import Trajectory
from tissuec.script.fit_problem import Fit
from tissuec.script.measures import MEASURES

T = TypeVar("T")


def read_hdf5(fits: Sequence[Fit], network: Network, complaints: Complaints) -> list[Series]:
    """Return the series of every fit in a file; errors of single fits go to ``complaints``.

    Raises:
        CompileError: It is damaged, or neither a result nor H5MD.
    """
    path = complaints.data.path
    try:
        try:
            with Trajectory(path) as result:
                return _each(fits, complaints, read_result, result, network)
        except ForeignFileError:
            with open_file(path, "r") as file:
                whole = ResultGroup(file, str(path), {})
                if not any(name in whole for name in GROUPS):
                    message = "is an HDF5 file, but neither a result of tissuec nor H5MD"
                    hint = "H5MD has the groups particles or observables"
                    complaints.reject("TIS604", f"{complaints.file} {message}", hint=hint)
                return _each(fits, complaints, read_h5md, whole, network)
    except (ResultError, OSError) as error:
        complaints.reject("TIS604", f"{complaints.file} cannot be read: {error}")


def _each(
    fits: Sequence[Fit],
    complaints: Complaints,
    read: Callable[[Fit, T, Network, Complaints], Series],
    file: T,
    network: Network,
) -> list[Series]:
    """Return the series of those fits that can be read."""
    series: list[Series] = []
    for fit in fits:
        with complaints.part():
            series.append(read(fit, file, network, complaints))
    return series


PARTICLES, OBSERVABLES = "particles", "observables"
GROUPS = (PARTICLES, OBSERVABLES)
#: Units of molecular dynamics beside our own.
_SMALL = {
    "ps": Unit(1e-12, TIME),
    "fs": Unit(1e-15, TIME),
    "pm": Unit(1e-12, LENGTH),
    "fm": Unit(1e-15, LENGTH),
    **dict.fromkeys(("A", "Angstrom", "angstrom", "Å"), Unit(1e-10, LENGTH)),
}


def read_h5md(fit: Fit, file: ResultGroup, network: Network, complaints: Complaints) -> Series:
    """Return the series of a fit in an H5MD file.

    Positions of nodes are those of the particles with their ids. Anything else is the
    observable of its name; where a position has none, it is the mean of the particles.

    Args:
        file: The open file.

    Raises:
        CompileError: There is no such observable, or there are no such particles.
    """
    reader = _SeriesReader(fit, file, network, complaints)
    if fit.measure is None:
        return reader.positions()
    found = reader.observables()
    name = find_log(fit, found)
    if name is not None:
        return reader.observable(found[name])
    if is_position(fit) and PARTICLES in file:
        series = reader.positions()
        if series.nodes is not None and len(series.nodes) == len(nodes_of(fit.subjects)):
            return Series(fit, series.times, None, as_measured(fit, series.values.mean(axis=1)))
        reader.reject(f"not all nodes of {title_of(fit)} are particles of {complaints.file}")
    title = title_of(fit)
    hint = alternatives(title, first_few(list(found)), what="its observables")
    reader.reject(f'{complaints.file} has no observable "{title}"', hint)


class _SeriesReader:
    """One fit in one file."""

    def __init__(self, fit: Fit, file: ResultGroup, network: Network, complaints: Complaints):
        self.fit, self.file, self.network = fit, file, network
        self.complaints = complaints

    def reject(self, message: str, hint: str = "", code: str = "TIS301") -> NoReturn:
        self.complaints.reject(code, message, self.fit.span, hint)

    # --- observables --------------------------------------------------------------------------

    def observables(self) -> dict[str, ResultGroup]:
        """Return all observables that have times, by their paths in the group."""
        if OBSERVABLES not in self.file:
            return {}
        top = access.group(self.file, OBSERVABLES)
        found = ((path, access.group(top, path)) for path in access.groups_below(top))
        return {
            path: group
            for path, group in found
            if "value" in group and getattr(group.member("value"), "shape", ())
        }

    def observable(self, group: ResultGroup) -> Series:
        """Return one observable."""
        value = access.dataset(group, "value")
        times, rows = self.times(group, len(value))
        components = self.numbers(value, self.fit.dimension)[rows].reshape(len(rows), -1)
        return Series(self.fit, times, None, as_measured(self.fit, components))

    # --- particles ----------------------------------------------------------------------------

    def positions(self) -> Series:
        """Return the places of those nodes that are particles."""
        nodes = nodes_of(self.fit.subjects)
        group = self.particles(nodes)
        position = access.group(group, "position")
        value = access.dataset(position, "value")
        if len(value.shape) != 3 or not 1 <= value.shape[2] <= 3:
            self.reject(
                f'"{value.path}" of {self.complaints.file} does not contain vectors for '
                "each frame"
            )
        times, rows = self.times(position, len(value))
        particles = self.numbers(value, LENGTH)[rows]
        places = np.full((len(rows), len(nodes), 3), np.nan)
        frame, node, particle = self.matches(group, nodes, value.shape[1], rows)
        axes = particles.shape[2]
        places[frame, node, :axes] = particles[frame, particle]
        seen = ~np.isnan(places).all(axis=(0, 2))
        if not seen.any():
            names = ", ".join(one.name for one in self.fit.subjects)
            self.reject(f"no node of {names} is a particle of {self.complaints.file}")
        return Series(self.fit, times, nodes[seen], places[:, seen])

    def particles(self, nodes: Indices) -> ResultGroup:
        """Return the group of particles that the nodes are among."""
        every = access.group(self.file, PARTICLES) if PARTICLES in self.file else ()
        groups = [name for name in every if f"{name}/position/value" in every]
        bodies = [body.name for body in owners(self.network, nodes)]
        names = [*(one.name for one in self.fit.subjects), *bodies, "all"]
        names += groups if len(groups) == 1 else []
        for name in names:
            if name in groups:
                return access.group(self.file, f"{PARTICLES}/{name}")
        hint = alternatives(names[0], groups, what="its groups of particles")
        self.reject(f'{self.complaints.file} has no particles "{names[0]}" that move', hint)

    def matches(
        self, group: ResultGroup, nodes: Indices, count: int, rows: Indices
    ) -> tuple[Indices, Indices, Indices]:
        """Return which particle is which node: frames, nodes and particles, shape (match,)."""
        ids = self.ids(group, nodes, count, rows)
        own = self.network.node_ids[nodes]
        order = np.argsort(own, kind="stable")
        if (np.diff(own[order]) == 0).any():
            self.reject(f"nodes of {self.fit.text} have the same ids", code="TIS313")
        place = np.minimum(np.searchsorted(own[order], ids), len(own) - 1)
        frame, particle = np.nonzero(own[order][place] == ids)
        return frame, order[place[frame, particle]], particle

    def ids(self, group: ResultGroup, nodes: Indices, count: int, rows: Indices) -> Indices:
        """Return the ids of particles in chosen frames, shape (row, particle)."""
        changing = "id/value" in group  # as the order of particles does
        if "id" in group:
            ids = access.array(group, "id/value" if changing else "id")
            if ids.shape[-1] != count or (changing and len(ids) <= rows[-1]):
                self.reject(f"{self.complaints.file} does not have one id per particle")
            return ids[rows] if changing else np.broadcast_to(ids, (len(rows), count))
        # Without ids they are those of the set, or of its body, in their order.
        bodies: list[Indices] = [numbers_in(b.nodes) for b in owners(self.network, nodes)]
        for whole in (nodes, *bodies):
            if len(whole) == count:
                return np.broadcast_to(self.network.node_ids[whole], (len(rows), count))
        self.reject(
            f"the {count} particles of {self.complaints.file} have no ids",
            f"without ids, there is one for each of the {len(nodes)} nodes of {self.fit.text}",
        )

    # --- times and units ----------------------------------------------------------------------

    def times(self, group: ResultGroup, count: int) -> tuple[Floats, Indices]:
        """Return the times that are used [s], and which rows they are."""
        if "time" not in group:
            self.reject(f'"{group.path}" of {self.complaints.file} has no times')
        member = access.dataset(group, "time")
        times = self.numbers(member, TIME)
        if not times.ndim:  # the time between rows, and perhaps that of the first one
            factor = self.unit(member, TIME)
            first = access.attribute_or(member, "offset", 0.0)
            times = first * factor + times * np.arange(count)
        wrong = np.flatnonzero(~(np.diff(times[:count]) > 0.0))
        if not count:
            self.reject(f'"{group.path}" of {self.complaints.file} contains no values')
        if len(wrong) or len(times) < count or np.isnan(times).any():
            where = f'"{group.path}" in {self.complaints.file}'
            row = f" at row {wrong[0] + 2}" if len(wrong) else ""
            self.reject(f"the times of {where} do not ascend{row}", code="TIS313")
        rows = nearest_rows(times[:count], self.fit.every)
        return times[rows], rows

    def numbers(self, member: Dataset, dimension: Dimension) -> Floats:
        """Return the numbers of a dataset in SI units."""
        if member.dtype.kind not in "fiu":
            self.reject(f'"{member.path}" of {self.complaints.file} contains no numbers')
        return np.asarray(member.whole(), dtype=float) * self.unit(member, dimension)

    def unit(self, member: Dataset, dimension: Dimension) -> float:
        """Return the factor from the unit of a dataset to SI."""
        text = access.attribute_or(member, "unit", "")
        if not text.strip():
            return 1.0
        where = f'"{member.path}" of {self.complaints.file} is in {text}'
        try:
            unit = _SMALL.get(text.strip()) or parse_unit(text)
        except UnitError:
            self.reject(f"{where}, an unknown unit", code="TIS104")
        if unit.dimension != dimension:
            self.reject(f"{where}; {describe(dimension)} is needed", code="TIS502")
        return unit.factor


def read_result(
    fit: Fit, result: Trajectory, network: Network, complaints: Complaints
) -> Series:
    """Return the series of a fit in a result.

    Positions are those of the frames. Anything else is that of the log of its name; where a
    position has none, it is the mean of the frames.

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


POSITION = "position"
_SIGNS = re.compile(r"[\W_]+")
_JOINING = ("of", "to")


def is_position(fit: Fit) -> bool:
    """Return whether the mean place of a set is fitted."""
    return fit.measure is MEASURES[POSITION]


def title_of(fit: Fit) -> str:
    """Return the name of the log of a fit: "force of pressed"."""
    key = next((name for name, measure in MEASURES.items() if measure is fit.measure), "")
    subjects = " to ".join(one.name for one in fit.subjects)
    return f"{key} of {subjects}" if subjects else key


def find_log(fit: Fit, names: Iterable[str]) -> str | None:
    """Return which of the logs of a file is that of a fit, however it is spelled."""
    wanted = [_plain(title_of(fit)), _plain(fit.text)]
    wanted += [_plain(column.name) for column in fit.columns[:1]]
    known = {_plain(name): name for name in reversed(list(names))}
    return next((known[name] for name in wanted if name in known), None)


def _plain(name: str) -> str:
    words = _SIGNS.sub(" ", name.lower()).split()
    return " ".join(word for word in words if word not in _JOINING)


def as_measured(fit: Fit, components: Floats) -> Floats:
    """Return the values that a fit compares.

    Args:
        components: Of its measure in SI units, shape (row, component).

    Returns:
        What is along a direction, or the one number, shape (row,); all components of a
        position and of what tables name three columns of, shape (row, 3).
    """
    width = components.shape[1]
    if fit.along is not None and width > 1:
        return fit.part(components)
    if width == 1:
        return components[:, 0]
    if width == 3 and (is_position(fit) or len(fit.columns) == 3):
        return components
    assert fit.measure is not None
    return fit.measure.value(components)
