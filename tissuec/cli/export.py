"""``tissuec export``: Write logs or tables as CSV, or frames as VTU or OBJ."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from msgspec import Struct

from tissuec.cli.arguments import TimeArgument
from tissuec.cli.common import Command, Settings, keep_input
from tissuec.core.errors import TissueError, counted, enumerated
from tissuec.core.files import replacing, write_file
from tissuec.core.hints import alternatives
from tissuec.core.report import Fact, Part, Report

if TYPE_CHECKING:
    from tissuec.model.network import Floats
    from tissuec.results.blocks.anatomy import Anatomy
    from tissuec.results.shapes import ExportedShape
    from tissuec.results.trajectory import Trajectory

HDF5 = "h5"
TABLES = ("csv", HDF5)  # formats of the tables of studies
VTM = "vtm"
FRAMES = ("vtu", "obj", "ply", VTM)
BLOCKS = "blocks"
FORMATS = ("csv", *FRAMES, "vtkhdf", BLOCKS, HDF5)
_BLOCKS_FILE = ".blocks.vtkhdf"
STDOUT = "-"


@click.command(cls=Command)
@click.argument("result", type=click.Path(path_type=Path))
@click.argument("logs", nargs=-1)
@click.option(
    "--format",
    "kind",
    type=click.Choice(FORMATS),
    help="Format of the output; by default from its name.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, allow_dash=True),
    help="File to write; by default CSV is printed on stdout.",
)
@click.option(
    "--surface", help="Export the recorded smooth surface of this body instead of the net."
)
@click.option(
    "--frame",
    type=int,
    help="Frame to write as VTU, OBJ, PLY or VTM, counted from 0; negative numbers count from "
    "the end.",
)
@click.option(
    "--time", "time", type=TimeArgument(), help="Write the frame nearest to this time instead."
)
@click.option("--all", "every", is_flag=True, help="Write all frames to numbered files.")
def command(
    settings: Settings,
    result: Path,
    logs: tuple[str, ...],
    kind: str | None,
    output: Path | None,
    surface: str | None,
    frame: int | None,
    time: float | None,
    every: bool,
) -> Report:
    """Write LOGS of RESULT as CSV, or frames as VTU, OBJ or PLY; or the table of a study.

    A file whose name ends with .blocks.vtkhdf contains all frames with the parts of bodies,
    joints and tools as blocks, and does not need RESULT. VTM is one frame with these blocks;
    with --all, a .pvd names all frames with their times.

    Without LOGS, all logs are written. The tables "energies" and "events" can be named too,
    "events" only alone. CSV has the units of plots, JSON (--json) SI units. A smooth surface in
    the format .vtkhdf contains all frames. RESULT may be the table of a study, which is written
    as CSV or HDF5; LOGS then name measures, for a plain CSV with a row for each run, or for
    each sample of a curve.

    \b
    tissuec export tube.vtkhdf "force of forceps A" > force.csv
    tissuec export tube.vtkhdf energies "force of forceps A" -o tube.csv
    tissuec export tube.vtkhdf --frame 0 -o tube.obj
    tissuec export tube.vtkhdf -o tube.blocks.vtkhdf
    tissuec export tube.vtkhdf --all -o frames/tube.vtm
    tissuec export tube.vtkhdf --surface oviduct --time 0.5 -o tube.ply
    tissuec export lift.stretching.csv pull > pull.csv
    """
    from tissuec.results.trajectory import Trajectory
    from tissuec.studies.table_files import is_table

    output = None if str(output) == STDOUT else output
    kind = kind or _kind(output)
    chosen = [name for name, is_there in (
        ("--frame", frame is not None), ("--time", time is not None), ("--all", every)
    ) if is_there]  # fmt: skip
    if is_table(result):
        if wrong := [*chosen, *(["--surface"] if surface is not None else [])]:
            raise click.UsageError(f'{wrong[0]} is for results; "{result}" is a table')
        return export_table(settings, result, logs, kind, output)
    _check_usage(kind, output, chosen, logs, surface)
    if output is not None:
        keep_input(output, result)
    with Trajectory.open(result) as trajectory:
        if kind == "csv":
            document = _tables(trajectory, logs, output, as_data=settings.json)
        elif kind == BLOCKS:
            document = _blocks(trajectory, output)
        else:
            series = _series(trajectory, kind, surface)
            document = _write_frames(series, kind, output, frame, time, every=every)
    parts = [] if output is None or kind == "csv" else _parts(document, output)
    return Report(parts, document, level="remark", is_table=output is None)


def _check_usage(
    kind: str,
    output: Path | None,
    chosen: list[str],
    logs: tuple[str, ...],
    surface: str | None,
) -> None:
    """Refuse options that do not go together."""
    if len(chosen) > 1:
        both = " and ".join(chosen)
        raise click.UsageError(f"{both} exclude each other; use one of them")
    if output is None and (chosen or surface is not None or kind != "csv"):
        raise click.UsageError(
            "-o names the file of a frame, such as -o frame.vtu, frame.obj or frame.ply"
        )
    if kind == HDF5:
        raise click.UsageError(".h5 is for tables of studies; a result is in HDF5 already")
    if kind == "csv" and chosen:
        raise click.UsageError(
            f"{chosen[0]} is for .vtu, .obj, .ply and .vtm; CSV contains all times"
        )
    if kind == "csv" and surface is not None:
        raise click.UsageError(
            "a surface needs the format .vtu, .obj, .ply or .vtkhdf, not CSV"
        )
    if logs and kind != "csv":
        raise click.UsageError(f"{kind.upper()} contains one frame, no logs; write logs as CSV")
    if kind == "vtkhdf" and surface is None:
        raise click.UsageError(
            f".vtkhdf needs --surface, or a name that ends with {_BLOCKS_FILE}; the result "
            "itself is the .vtkhdf of the net"
        )
    if kind in (BLOCKS, VTM) and surface is not None:
        raise click.UsageError("blocks contain all surfaces; remove --surface")
    if kind in ("vtkhdf", BLOCKS) and chosen:
        raise click.UsageError(f".vtkhdf contains all frames; remove {chosen[0]}")


def _tables(
    trajectory: "Trajectory", names: tuple[str, ...], output: Path | None, *, as_data: bool
) -> dict[str, Any]:
    """Write tables as CSV; return the JSON document: the tables, or their file."""
    from tissuec.results.export import table_data, table_names, table_rows, write_csv

    names = names or tuple(trajectory.logs)
    if not names:
        other = [f'"{name}"' for name in table_names(trajectory)]
        other += ["a frame with -o frame.vtu"] if len(trajectory.times) else []
        hint = f"; export {' or '.join(other)}" if other else " and nothing else to export"
        raise TissueError(f'"{trajectory.path}" has no logs{hint}')
    if output is None and as_data:
        return table_data(trajectory, names)
    rows = table_rows(trajectory, names)  # a name that is wrong is found before a file is made
    if output is None:
        write_csv(rows, sys.stdout)
        return {}
    with replacing(output) as beside, beside.open("w", encoding="utf-8", newline="") as stream:
        write_csv(rows, stream)
    return {"file": str(output), "tables": names}


class _Series(Struct, frozen=True):
    """What can be written of each frame.

    Attributes:
        times: Of the frames [s].
        write: Writes a frame; takes its number, the format, the file, and the ending of a
            numbered name.
        save: Writes all frames to one file.
        left_out: Sentences about what is not written.
    """

    times: "Floats"
    write: Callable[[int, str, Path, str], None]
    save: Callable[[Path], None] | None = None
    left_out: tuple[str, ...] = ()


def _shapes(shape: "Callable[[int], ExportedShape]") -> Callable[[int, str, Path, str], None]:
    """Return the function that writes a shape of each frame."""
    from tissuec.results.shapes import WRITERS

    return lambda number, kind, path, _: WRITERS[kind](shape(number), path)


def _blocks(trajectory: "Trajectory", output: Path | None) -> dict[str, Any]:
    """Write a blocks file; return the JSON document."""
    from tissuec.results.blocks.file import write_blocks

    assert output is not None
    anatomy, left_out = _anatomy(trajectory)
    written = write_blocks(trajectory, anatomy, output, links=False)
    return {
        "file": str(output),
        "frames": len(trajectory.times),
        "blocks": list(written.names),
        "left_out": [*left_out, *written.left_out],
    }


def _anatomy(trajectory: "Trajectory") -> "tuple[Anatomy | None, list[str]]":
    """Return the anatomy of the scene of a result, and the omissions if it is unknown."""
    from tissuec.analysis.result_scene import anatomy_of_result

    anatomy, reason = anatomy_of_result(trajectory)
    if anatomy is not None:
        return anatomy, []
    return None, [
        f"tissues, strains, stresses and tools without a shape are left out: {reason}"
    ]


def _net(trajectory: "Trajectory") -> _Series:
    from tissuec.results.export import frame_shape

    _need_frames(trajectory)
    return _Series(trajectory.times, _shapes(lambda number: frame_shape(trajectory, number)))


def _series(trajectory: "Trajectory", kind: str, surface: str | None) -> _Series:
    if kind == VTM:
        return _pieces(trajectory)
    return _net(trajectory) if surface is None else _surface(trajectory, surface)


def _pieces(trajectory: "Trajectory") -> _Series:
    from tissuec.results.blocks.pieces import BlockFrames

    _need_frames(trajectory)
    anatomy, left_out = _anatomy(trajectory)
    frames = BlockFrames(trajectory, anatomy)
    return _Series(
        trajectory.times,
        lambda number, _, path, ending: frames.write(number, path, ending),
        left_out=(*left_out, *frames.left_out),
    )


def _need_frames(trajectory: "Trajectory") -> None:
    if not len(trajectory.times):
        raise TissueError("this result has no frames, because the scene records no trajectory")


def _surface(trajectory: "Trajectory", name: str) -> _Series:
    from tissuec.results.export import export_surface, surface_shape

    surfaces = trajectory.surfaces
    key = next((one for one in surfaces if one.lower() == name.lower()), None)
    if key is None:
        message = f'"{trajectory.path}" has no surface of "{name}"'
        hint = alternatives(name, surfaces, what="there are") if surfaces else (
            f"write output {{ surface of {name} every 40 ms }} and run the scene again"
        )  # fmt: skip
        raise TissueError(f"{message}; {hint}")
    series = surfaces[key]
    if not len(series):
        raise TissueError(f'the surface of "{key}" has no frames yet')
    return _Series(
        series.times,
        _shapes(lambda number: surface_shape(series, number)),
        lambda path: export_surface(series, path),
    )


def _write_frames(
    series: _Series, kind: str, output: Path | None, frame: int | None, time: float | None, *,
    every: bool,
) -> dict[str, Any]:  # fmt: skip
    assert output is not None
    left_out = {"left_out": list(series.left_out)} if series.left_out else {}
    if kind == "vtkhdf":
        assert series.save is not None
        series.save(output)
        return {"file": str(output), "frames": len(series.times)}
    if not every:
        number = _frame(series.times, frame, time)
        series.write(number, kind, output, "")
        shown = float(series.times[number])
        return {"file": str(output), "frame": number, "time": shown, **left_out}
    width = max(4, len(str(len(series.times) - 1)))
    endings = [f"_{n:0{width}}" for n in range(len(series.times))]
    files = [output.with_name(f"{output.stem}{end}{output.suffix}") for end in endings]
    for number, (file, ending) in enumerate(zip(files, endings, strict=True)):
        series.write(number, kind, file, ending)
    if kind == VTM:
        from tissuec.results.blocks.pieces import write_series

        write_series(files, series.times, output.with_suffix(".pvd"))
    return {"files": list(map(str, files)), **left_out}


def _parts(document: dict[str, Any], output: Path) -> list[Part]:
    """Describe the written frames and the omitted parts."""
    notes = [Fact("note", sentence) for sentence in document.get("left_out", ())]
    return [_written(document, output), *notes]


def _written(document: dict[str, Any], output: Path) -> str:
    if "files" in document:
        first, last = document["files"][0], document["files"][-1]
        return f"wrote {counted(len(document['files']), 'frame')} to {first} … {last}"
    if "frames" in document:
        return f"wrote {counted(document['frames'], 'frame')} to {output}"
    return f"wrote frame {document['frame']} (t = {document['time']:g} s) to {output}"


def _kind(output: Path | None) -> str:
    if output is None:
        return "csv"
    if output.name.lower().endswith(_BLOCKS_FILE):
        return BLOCKS
    kind = output.suffix.lower().lstrip(".")
    if kind not in FORMATS or kind == BLOCKS:
        ends = enumerated((f".{one}" for one in FORMATS if one != BLOCKS), "or")
        raise click.UsageError(f'"{output}" does not end with {ends}; use --format')
    return kind


def _frame(times: "Floats", frame: int | None, time: float | None) -> int:
    """Return the number of the frame that is meant, from 0."""
    if time is not None:
        return int(abs(times - time).argmin())
    number = -1 if frame is None else frame
    if not -len(times) <= number < len(times):
        raise TissueError(
            f"there is no frame {number}; the result has {len(times)}, counted from 0"
        )
    return number % len(times)


def export_table(
    settings: Settings, path: Path, names: tuple[str, ...], kind: str, output: Path | None
) -> Report:
    """Write a table, or some of its columns.

    Args:
        settings: Of the program.
        path: The table.
        names: Of measures and curves; if there are none, the whole table is written.
        kind: "csv" or "h5".
        output: The file; None for stdout.

    Raises:
        UsageError: The format cannot hold what is requested.
        TissueError: The table cannot be read, a column is none of it, or nothing is written.
    """
    from tissuec.studies.table_files import read_table

    if kind not in TABLES:
        raise click.UsageError(
            f'"{path}" is the table of a study, which has no frames; write it as .csv or .h5. '
            "Netcdf is written from Python: tissuec.read_table(…).to_xarray().to_netcdf(…)"
        )
    if kind == HDF5 and (names or output is None):
        wrong = "contains whole tables, no single columns; write these as CSV"
        raise click.UsageError(f"HDF5 {wrong if names else 'needs a file: -o table.h5'}")
    if output is not None:
        keep_input(output, path)
    table = read_table(path)
    if output is None and settings.json:
        return Report((), _plain(table, names), is_table=True)
    _write_table(table, names, kind, output)
    parts: list[Part] = [] if output is None else [f"wrote {output}"]
    return Report(parts, {"file": str(output), "runs": len(table)}, level="remark")


def _plain(table: Any, names: tuple[str, ...]) -> dict[str, Any]:
    """Return columns by their heads."""
    from tissuec.studies.table_files import export

    found = export(table, names or [one.name for one in (*table.measures, *table.curves)])
    return dict(zip(found.heads, zip(*found.rows, strict=True), strict=True))


def _write_table(table: Any, names: tuple[str, ...], kind: str, output: Path | None) -> None:
    """Write a table to a file or stdout."""
    if kind == HDF5:
        from tissuec.studies.table_hdf5 import write_hdf5

        assert output is not None
        write_hdf5(table, output)
        return
    text = _csv(table, names)
    if output is None:
        sys.stdout.write(text)
        return
    try:
        write_file(output, text)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise TissueError(f'cannot write "{output}": {reason}') from error


def _csv(table: Any, names: tuple[str, ...]) -> str:
    """Return the whole table in the format that can be read again, or columns as plain CSV."""
    from tissuec.studies.table import rows_of
    from tissuec.studies.table_text import as_csv

    if not names:
        return as_csv(table.head, rows_of(table))
    from io import StringIO

    from tissuec.results.export import write_csv
    from tissuec.studies.table_files import export

    found, stream = export(table.shown, names), StringIO(newline="")
    write_csv([found.heads, *found.rows], stream)
    return stream.getvalue()
