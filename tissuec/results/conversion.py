"""Results as tables of pandas, datasets of xarray and meshes of PyVista, where installed."""

from collections.abc import Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tissuec.core.hints import alternatives
from tissuec.results.export import find_log, moments_of, names_of
from tissuec.results.frame_columns import MOTION, OverFrames
from tissuec.results.shapes import ExportedShape
from tissuec.results.tables import Log
from tissuec.results.trajectory import Trajectory

if TYPE_CHECKING:
    import pandas  # pyright: ignore[reportMissingImports, reportMissingTypeStubs]
    import pyvista  # pyright: ignore[reportMissingImports]
    import xarray  # pyright: ignore[reportMissingImports]

EVENTS = "events"
TIME = "time [s]"


def to_pandas(trajectory: Trajectory, names: Sequence[str]) -> "pandas.DataFrame":
    """Return logs as one table; see `Trajectory.to_pandas`."""
    pandas = package("pandas", "to_pandas")
    if list(names) == [EVENTS] and EVENTS not in trajectory.logs:
        return _events(trajectory, pandas)
    logs = [find_log(trajectory, name) for name in names or trajectory.logs]
    if len(names) == 1:
        log = logs[0]
        index = pandas.Index(log.time, name=TIME)
        table = pandas.DataFrame(log.value, index=index, columns=list(log.columns))
    else:
        table = _joined(logs, pandas)
    table.attrs["units"] = {log.name: log.unit for log in logs}
    return table


def _joined(logs: Sequence[Log], pandas: Any) -> "pandas.DataFrame":
    """Return logs beside one another; a moment that a log has twice stands there twice."""
    if not logs:
        return pandas.DataFrame(index=pandas.Index([], name=TIME, dtype=float))
    keys = [moments_of(log.time) for log in logs]
    moments, place = np.unique(np.concatenate(keys), axis=0, return_inverse=True)
    ends = np.cumsum([len(key) for key in keys])[:-1]
    columns: list[tuple[str, str | int]] = []
    values: list[NDArray[np.float64]] = []
    for log, rows in zip(logs, np.split(place.reshape(-1), ends), strict=True):
        value = np.full((len(moments), len(log.columns)), np.nan)
        value[rows] = log.value
        values.append(value)
        columns += [(log.name, column) for column in log.columns]
    heads = pandas.MultiIndex.from_tuples(columns, names=["log", "column"])
    index = pandas.Index(moments[:, 0], name=TIME)
    return pandas.DataFrame(np.concatenate(values, axis=1), index, heads)


def _events(trajectory: Trajectory, pandas: Any) -> "pandas.DataFrame":
    """Return a row per event, with the ids of its springs."""
    columns = {
        "kind": [event.kind for event in trajectory.events],
        "cause": [event.cause for event in trajectory.events],
        "place": [event.place for event in trajectory.events],
        "springs": [names_of(trajectory, event) for event in trajectory.events],
    }
    index = pandas.Index([event.time for event in trajectory.events], name=TIME, dtype=float)
    return pandas.DataFrame(columns, index=index)


def to_xarray(trajectory: Trajectory, names: Sequence[str], frames: slice) -> "xarray.Dataset":
    """Return frames as a dataset; see `Trajectory.to_xarray`.

    Args:
        trajectory: The result.
        names: Arrays to include; all if empty.
        frames: Range of frames.

    Raises:
        ValueError: Frames have no array of this name.
    """
    xarray = package("xarray", "to_xarray")
    arrays = _arrays(trajectory)
    for name in names:
        if name not in arrays:
            hint = alternatives(name, arrays, what="there are")
            raise ValueError(f'frames have no "{name}"; {hint}')
    data = {}
    for name in names or arrays:
        array, axes, text = arrays[name]
        about = {"units": array.unit, "long_name": text}
        data[name] = (("time", *axes), array[frames], about)
    manifest = trajectory.manifest
    about = {name: manifest[name] for name in ("scene", "outcome", "digest")}
    return xarray.Dataset(data, _coordinates(trajectory, frames), about)


def _arrays(trajectory: Trajectory) -> dict[str, tuple[OverFrames, tuple[str, ...], str]]:
    """Return arrays over frames by name, with axes behind that of time and texts."""
    found: dict[str, tuple[OverFrames, tuple[str, ...], str]] = {}
    for channel in (*MOTION, *trajectory.channels):
        of_row = {1: (), 3: ("axis",), 6: ("component",)}[channel.width]
        axes = (channel.at, *of_row)
        gone = channel.at in ("spring", "triangle", "element")
        text = f"{channel.text}; NaN after a {channel.at} is gone" if gone else channel.text
        found[channel.key] = trajectory.frames_of(channel), axes, text
    return found


def _coordinates(trajectory: Trajectory, frames: slice) -> dict[str, Any]:
    network, nodes, springs = trajectory.network, trajectory.nodes, trajectory.springs
    bodies = _names(network.node_count, [(body.name, body.nodes) for body in network.bodies])
    parts = _names(network.spring_count, [(part.name, part.springs) for part in network.parts])
    ends = trajectory.ends[: len(springs)]
    return {
        "time": ("time", trajectory.times[frames], {"units": "s"}),
        "axis": ("axis", ["x", "y", "z"]),
        "node": ("node", nodes, {"long_name": "numbers in the network"}),
        "node_id": ("node", trajectory.node_ids, {"long_name": "ids of the scene"}),
        "body": ("node", bodies[nodes]),
        "spring": ("spring", springs, {"long_name": "numbers in the network"}),
        "spring_id": ("spring", trajectory.spring_ids, {"long_name": "ids of the scene"}),
        "part": ("spring", parts[springs]),
        "first": ("spring", ends[:, 0], {"long_name": "rows of its nodes"}),
        "second": ("spring", ends[:, 1], {"long_name": "rows of its nodes"}),
    }


def _names(count: int, places: Sequence[tuple[str, slice]]) -> NDArray[np.str_]:
    """Return the name of what each of so many numbers belongs to, "" where nothing does."""
    names = np.full(count, "", dtype=object)
    for name, place in places:
        names[place] = name
    return names.astype(str)


def to_pyvista(shape: ExportedShape) -> "pyvista.UnstructuredGrid":
    """Return a shape as a mesh of PyVista; see `Trajectory.to_pyvista`.

    Raises:
        ImportError: PyVista is not installed.
    """
    pyvista = package("pyvista", "to_pyvista", extra="pyvista")
    grid, points = shape.grid, np.array(shape.points)
    cells = np.insert(grid.points, grid.ends[:-1], np.diff(grid.ends))
    mesh = pyvista.UnstructuredGrid(cells, grid.types, points)
    for data, values in (
        (mesh.point_data, shape.point_data),
        (mesh.cell_data, shape.cell_data),
        (mesh.field_data, {"TimeValue": np.array([shape.time])}),
    ):
        for name, numbers in values.items():
            data.set_array(numbers, name, deep_copy=True)
    return mesh


def package(name: str, what: str, *, extra: str = "notebook") -> Any:
    """Return an optional package, imported for ``what``.

    Args:
        name: Of the package.
        what: What needs it.
        extra: Which installs it.

    Raises:
        ImportError: It is not installed.
    """
    try:
        return import_module(name)
    except ImportError as error:
        raise ImportError(
            f"{what} needs {name}, which is not installed; "
            f'pip install "tissuec[{extra}]" installs it'
        ) from error
