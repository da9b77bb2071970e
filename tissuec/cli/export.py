"""``tissuec export``: Write logs or tables as CSV, or frames as VTU or OBJ."""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from msgspec import Struct

from tissuec.cli.arguments import TimeArgument
from tissuec.cli.common import DONE, Command, Settings, keep_input, print_json
from tissuec.cli.exporting_tables import HDF5, export_table
from tissuec.core.errors import TissueError, counted
from tissuec.core.files import replacing
from tissuec.core.hints import alternatives

if TYPE_CHECKING:
    from tissuec.model.network import Floats
    from tissuec.results.shapes import ExportedShape
    from tissuec.results.trajectory import Trajectory

FRAMES = ("vtu", "obj", "ply")
FORMATS = ("csv", *FRAMES, "vtkhdf", HDF5)
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
    help="Frame to write as VTU, OBJ or PLY, counted from 0; negative numbers count from "
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
) -> int:
    """Write LOGS of RESULT as CSV, or frames as VTU, OBJ or PLY; or the table of a study.

    Without LOGS, all logs are written. The tables "energies" and "events" can be named too,
    "events" only alone. With --json, the output on stdout is JSON. A smooth surface in the
    format .vtkhdf contains all frames. RESULT may be the table of a study, which is written as
    CSV or HDF5; LOGS then name measures, for a plain CSV with a row for each run, or for each
    sample of a curve.

    \b
    tissuec export tube.vtkhdf "force of forceps A" > force.csv
    tissuec export tube.vtkhdf energies "force of forceps A" -o tube.csv
    tissuec export tube.vtkhdf --frame 0 -o tube.obj
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
        else:
            assert output is not None
            series = _net(trajectory) if surface is None else _surface(trajectory, surface)
            document = _write_frames(series, kind, output, frame, time, every=every)
    if settings.json:
        print_json(document)
    elif output is not None and kind != "csv":
        settings.say(_told(document, output))
    return DONE


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
            f"{chosen[0]} is for .vtu, .obj and .ply; CSV contains all times"
        )
    if kind == "csv" and surface is not None:
        raise click.UsageError(
            "a surface needs the format .vtu, .obj, .ply or .vtkhdf, not CSV"
        )
    if logs and kind != "csv":
        raise click.UsageError(f"{kind.upper()} contains one frame, no logs; write logs as CSV")
    if kind == "vtkhdf" and surface is None:
        raise click.UsageError(
            ".vtkhdf needs --surface; the result itself is the .vtkhdf of the net"
        )
    if kind == "vtkhdf" and chosen:
        raise click.UsageError(f".vtkhdf contains all frames; remove {chosen[0]}")


def _tables(
    trajectory: "Trajectory", names: tuple[str, ...], output: Path | None, *, as_data: bool
) -> dict[str, Any]:
    """Write tables as CSV; return what ``--json`` says of it: the tables, or where they are."""
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
    """What there is a shape of in each frame."""

    times: "Floats"
    shape: "Callable[[int], ExportedShape]"
    save: "Callable[[Path], None] | None"  # all frames in one file


def _net(trajectory: "Trajectory") -> _Series:
    from tissuec.results.export import frame_shape

    if not len(trajectory.times):
        raise TissueError("this result has no frames, because the scene records no trajectory")
    return _Series(trajectory.times, lambda number: frame_shape(trajectory, number), None)


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
        lambda number: surface_shape(series, number),
        lambda path: export_surface(series, path),
    )


def _write_frames(
    series: _Series, kind: str, output: Path, frame: int | None, time: float | None, *,
    every: bool,
) -> dict[str, Any]:  # fmt: skip
    from tissuec.results.shapes import WRITERS

    if kind == "vtkhdf":
        assert series.save is not None
        series.save(output)
        return {"file": str(output), "frames": len(series.times)}
    if not every:
        number = _frame(series.times, frame, time)
        WRITERS[kind](series.shape(number), output)
        return {"file": str(output), "frame": number, "time": float(series.times[number])}
    width = max(4, len(str(len(series.times) - 1)))
    names = [f"{output.stem}_{n:0{width}}{output.suffix}" for n in range(len(series.times))]
    for number, name in enumerate(names):
        WRITERS[kind](series.shape(number), output.with_name(name))
    return {"files": [str(output.with_name(name)) for name in names]}


def _told(document: dict[str, Any], output: Path) -> str:
    """Return what was written, in words."""
    if "files" in document:
        first, last = document["files"][0], document["files"][-1]
        return f"wrote {counted(len(document['files']), 'frame')} to {first} … {last}"
    if "frames" in document:
        return f"wrote {counted(document['frames'], 'frame')} to {output}"
    return f"wrote frame {document['frame']} (t = {document['time']:g} s) to {output}"


def _kind(output: Path | None) -> str:
    if output is None:
        return "csv"
    kind = output.suffix.lower().lstrip(".")
    if kind not in FORMATS:
        *others, last = (f".{one}" for one in FORMATS)
        ends = f"{', '.join(others)} or {last}"
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
