"""``tissuec export``"""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tissuec.cli.common import DONE, Command, Settings, keep_input, print_json
from tissuec.core.errors import TissueError

if TYPE_CHECKING:
    from tissuec.network import Floats
    from tissuec.results.trajectory import Trajectory

FORMATS = ("csv", "vtu", "obj")
STDOUT = "-"


@click.command(cls=Command)
@click.argument("result", type=click.Path(path_type=Path))
@click.argument("logs", nargs=-1)
@click.option(
    "--format",
    "kind",
    type=click.Choice(FORMATS),
    help="From the name of the output if not given.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, allow_dash=True),
    help="File to write; CSV goes to stdout without it.",
)
@click.option(
    "--frame",
    type=int,
    help="Frame to write as VTU or OBJ, counted from 0; negative from the end.",
)
@click.option(
    "--time", "time", type=float, help="The frame nearest to this time in seconds instead."
)
def command(
    settings: Settings,
    result: Path,
    logs: tuple[str, ...],
    kind: str | None,
    output: Path | None,
    frame: int | None,
    time: float | None,
) -> int:
    """Write LOGS of RESULT as CSV, or one frame as VTU or OBJ.

    Without LOGS, all that the scene asked for. The tables "energies" and "events" can be named
    too, the latter by itself. With --json, what goes to stdout is JSON.

    \b
    tissuec export tube.vtkhdf "force of forceps A" > force.csv
    tissuec export tube.vtkhdf energies "force of forceps A" -o tube.csv
    tissuec export tube.vtkhdf --frame 0 -o tube.obj
    """
    from tissuec.results.trajectory import Trajectory

    output = None if str(output) == STDOUT else output
    kind = kind or _kind(output)
    chosen = frame is not None or time is not None
    if frame is not None and time is not None:
        raise click.UsageError("--frame and --time each choose a frame; say one of them")
    if output is None and (chosen or kind != "csv"):
        raise click.UsageError(
            "-o names the file of a frame, such as -o frame.vtu or frame.obj"
        )
    if chosen and kind == "csv":
        raise click.UsageError("--frame and --time are for .vtu and .obj; CSV has all times")
    if logs and kind != "csv":
        raise click.UsageError(f"{kind.upper()} has no logs, only a frame; CSV has logs")
    if output is not None:
        keep_input(output, result)
    with Trajectory.open(result) as trajectory:
        if kind == "csv":
            document = _tables(trajectory, logs, output, as_data=settings.json)
        else:
            assert output is not None
            number = _frame(trajectory.times, frame, time)
            document = _write_frame(trajectory, number, kind, output)
    if settings.json:
        print_json(document)
    elif output is not None and kind != "csv":
        settings.say(
            f"wrote frame {document['frame']} (t = {document['time']:g} s) to {output}"
        )
    return DONE


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
        raise TissueError(f'"{trajectory.path}" holds no logs{hint}')
    if output is None and as_data:
        return table_data(trajectory, names)
    rows = table_rows(trajectory, names)  # a name that is wrong is found before a file is made
    if output is None:
        write_csv(rows, sys.stdout)
        return {}
    with open(output, "w", encoding="utf-8", newline="") as stream:
        write_csv(rows, stream)
    return {"file": str(output), "tables": names}


def _write_frame(
    trajectory: "Trajectory", number: int, kind: str, output: Path
) -> dict[str, Any]:
    from tissuec.results.export import export_obj, export_vtu

    (export_vtu if kind == "vtu" else export_obj)(trajectory, number, output)
    return {"file": str(output), "frame": number, "time": float(trajectory.times[number])}


def _kind(output: Path | None) -> str:
    if output is None:
        return "csv"
    kind = output.suffix.lower().lstrip(".")
    if kind not in FORMATS:
        raise click.UsageError(f'"{output}" ends with none of .csv, .vtu, .obj; say --format')
    return kind


def _frame(times: "Floats", frame: int | None, time: float | None) -> int:
    """Return the number of the frame that is meant, from 0."""
    if not len(times):
        raise TissueError("this result has no frames; the scene asks for no trajectory")
    if time is not None:
        return int(abs(times - time).argmin())
    number = -1 if frame is None else frame
    if not -len(times) <= number < len(times):
        raise TissueError(f"there is no frame {number}; there are {len(times)}, counted from 0")
    return number % len(times)
