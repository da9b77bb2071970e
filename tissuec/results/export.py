"""Results for other programs: tables as CSV, single frames as VTU and OBJ."""

import csv
from base64 import b64encode
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, TextIO
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import NDArray

from tissuec.core.errors import alternatives
from tissuec.network import Floats
from tissuec.results.errors import ResultError
from tissuec.results.recording import body_of
from tissuec.results.trajectory import Log, Trajectory

_VTK_TYPES = {"float32": "Float32", "float64": "Float64", "int64": "Int64", "uint8": "UInt8"}


def export_csv(trajectory: Trajectory, names: str | Sequence[str], stream: TextIO) -> None:
    """Write the rows of a table as comma-separated values; see ``table_rows``."""
    write_csv(table_rows(trajectory, names), stream)


def write_csv(rows: Iterable[Sequence[object]], stream: TextIO) -> None:
    """Write rows as comma-separated values."""
    csv.writer(stream, lineterminator="\n").writerows(rows)


def table_rows(
    trajectory: Trajectory, names: str | Sequence[str]
) -> Iterable[Sequence[object]]:
    """Return logs, "energies" or "events" as the rows of one table, its head first.

    Logs of different times share one table, with empty fields where one has no row. Numbers
    have as many digits as it takes to read back the same ones.

    Args:
        trajectory: Where from.
        names: One name or several; "events" stands alone.

    Raises:
        ResultError: There is no such log.
    """
    names = [names] if isinstance(names, str) else list(names)
    if names == ["events"] and "events" not in trajectory.logs:
        return _event_rows(trajectory)
    logs = [_find_log(trajectory, name) for name in names]
    head = ["time [s]", *(head for log in logs for head in _heads(log))]
    return chain([head], _joined_rows(logs))


def table_names(trajectory: Trajectory) -> list[str]:
    """Return the names of all tables that hold something."""
    energies = ["energies"] if trajectory.energies is not None else []
    return [*trajectory.logs, *energies, *(["events"] if trajectory.events else [])]


def table_data(trajectory: Trajectory, names: Sequence[str]) -> dict[str, Any]:
    """Return tables by name, as plain data for programs.

    Raises:
        ResultError: There is no such log.
    """
    return {name: _plain_table(trajectory, name) for name in names}


def _plain_table(trajectory: Trajectory, name: str) -> Any:
    if name == "events" and "events" not in trajectory.logs:
        heads, *rows = _event_rows(trajectory)
        return [dict(zip(["time", *heads[1:]], row, strict=True)) for row in rows]
    log = _find_log(trajectory, name)
    return {
        "columns": list(log.columns),
        "unit": log.unit,
        "time": log.time.tolist(),
        "value": log.value.tolist(),
    }


def export_vtu(trajectory: Trajectory, frame: int, path: Path) -> None:
    """Write one frame as a VTK unstructured grid (XML, ``.vtu``).

    Raises:
        IndexError: There is no such frame.
        ResultError: The file cannot be written.
    """
    cells = trajectory.cells(frame)
    tension, rows = trajectory.spring_force(frame)
    numbers = np.full(cells.total, np.nan, dtype=tension.dtype)
    numbers[cells.line_rows] = tension
    identities = np.full(cells.total, -1, dtype=np.int64)
    identities[cells.line_rows] = trajectory.spring_ids[rows]
    tables = {1: cells.vertices, 3: cells.lines, 5: cells.triangles}  # VTK's numbers of kinds
    sizes = np.concatenate(
        [np.full(len(t), t.shape[1], dtype=np.int64) for t in tables.values()]
    )
    kinds = np.concatenate(
        [np.full(len(t), kind, dtype=np.uint8) for kind, t in tables.items()]
    )
    points = {
        "velocity": trajectory.velocity[frame],
        "force": trajectory.force[frame],
        "node_id": trajectory.node_ids,
    }
    topology = {
        "connectivity": np.concatenate([t.reshape(-1) for t in tables.values()]),
        "offsets": np.cumsum(sizes),
        "types": kinds,
    }
    body = [
        _section("FieldData", {"TimeValue": trajectory.times[frame][None]}, tuples=True),
        f'<Piece NumberOfPoints="{len(trajectory.nodes)}" NumberOfCells="{cells.total}">\n',
        _section("Points", {"position": trajectory.position[frame]}),
        _section("Cells", topology),
        _section("PointData", points),
        _section("CellData", {"spring_force": numbers, "spring_id": identities}),
        "</Piece>\n",
    ]
    head = '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian"'
    lines = [f'{head} header_type="UInt64">\n<UnstructuredGrid>\n', *body]
    _write(path, [*lines, "</UnstructuredGrid>\n</VTKFile>\n"])


def export_obj(trajectory: Trajectory, frame: int, path: Path) -> None:
    """Write one frame as Wavefront OBJ: vertices, springs as lines, skin as faces.

    Raises:
        IndexError: There is no such frame.
        ResultError: The file cannot be written.
    """
    cells = trajectory.cells(frame)
    parts = {"p": cells.vertices, "l": cells.lines, "f": cells.triangles}
    lines = [f"# {trajectory.path.name}, {float(trajectory.times[frame])!r} s, in metres\n"]
    lines += [_obj_line("v", row) for row in trajectory.position[frame].tolist()]
    for letter, table in parts.items():
        lines += [_obj_line(letter, row) for row in (table + 1).tolist()]  # OBJ counts from 1
    _write(path, lines)


def _obj_line(letter: str, numbers: Iterable[float]) -> str:
    return " ".join([letter, *map(repr, numbers)]) + "\n"


def _find_log(trajectory: Trajectory, name: str) -> Log:
    if name in trajectory.logs:
        return trajectory.logs[name]
    if name == "energies" and trajectory.energies is not None:
        return trajectory.energies
    if name == "events":
        raise ResultError('"events" are a table of their own; export them by themselves')
    hint = alternatives(name, table_names(trajectory), what="there are")
    raise ResultError(f'"{trajectory.path}" has no log "{name}" to put into a table; {hint}')


def _heads(log: Log) -> list[str]:
    unit = f"[{log.unit}]" if log.unit else ""
    return [" ".join(filter(None, (log.name, str(column), unit))) for column in log.columns]


def _joined_rows(logs: Sequence[Log]) -> Iterable[list[object]]:
    """Yield one row per moment of any log; a moment that a log has twice stands there twice."""
    keys = [_moments(log.time) for log in logs]
    moments, place = np.unique(np.concatenate(keys), axis=0, return_inverse=True)
    ends = np.cumsum([len(key) for key in keys])
    tables = []
    for log, rows in zip(logs, np.split(place.reshape(-1), ends[:-1]), strict=True):
        table: list[list[object]] = [[""] * len(log.columns)] * len(moments)
        for row, values in zip(rows.tolist(), log.value.tolist(), strict=True):
            table[row] = values
        tables.append(table)
    for moment, *values in zip(moments[:, 0].tolist(), *tables, strict=True):
        yield [moment, *(number for row in values for number in row)]


def _moments(time: Floats) -> Floats:
    """Return each time and the how-manieth of its kind it is, shape (moment, 2)."""
    order = np.argsort(time, kind="stable")
    ordered = time[order]
    again = np.empty(len(time))
    again[order] = np.arange(len(time)) - np.searchsorted(ordered, ordered)
    return np.column_stack([time, again])


def _event_rows(trajectory: Trajectory) -> Iterator[list[Any]]:
    yield ["time [s]", "kind", "springs", "cause", "place"]
    for event in trajectory.events:
        springs = " ".join(_spring_name(trajectory, number) for number in event.springs)
        yield [event.time, event.kind, springs, event.cause, event.place]


def _spring_name(trajectory: Trajectory, number: int) -> str:
    """Return the id of a spring, with its body where there are several that count their own."""
    network = trajectory.network
    identity = str(network.spring_ids[number])
    if len(network.bodies) < 2:
        return identity
    return f"{body_of(network, int(network.ends[number, 0]))}:{identity}"


def _section(name: str, arrays: dict[str, NDArray], *, tuples: bool = False) -> str:
    texts = [_data_array(key, data, tuples=tuples) for key, data in arrays.items()]
    return f"<{name}>\n{''.join(texts)}</{name}>\n"


def _data_array(name: str, data: NDArray, *, tuples: bool) -> str:
    """Return an array as VTK's XML has it: base64 of its length in bytes and its bytes."""
    kind = _VTK_TYPES[data.dtype.name]
    plain = data.astype(data.dtype.newbyteorder("<")).tobytes()
    code = b64encode(np.array(len(plain), dtype="<u8").tobytes() + plain).decode()
    count = f' NumberOfTuples="{len(data)}"' if tuples else ""
    width = f' NumberOfComponents="{data.shape[1]}"' if data.ndim == 2 else ""
    attributes = f'type="{kind}" Name={quoteattr(name)}{width}{count} format="binary"'
    return f"<DataArray {attributes}>{code}</DataArray>\n"


def _write(path: Path, lines: Iterable[str]) -> None:
    try:
        with open(path, "w", encoding="utf-8", newline="\n") as stream:
            stream.writelines(lines)
    except OSError as error:
        raise ResultError(f'cannot write "{path}": {error.strerror}') from error
