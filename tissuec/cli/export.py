"""``tissuec export``"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

import click

from tissuec.cli.common import DONE, Command, Settings, cannot_write
from tissuec.core.errors import TissueError

if TYPE_CHECKING:
    from tissuec.network import Floats

FORMATS = ("csv", "vtu", "obj")


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

    \b
    tissuec export tube.vtkhdf "force of forceps A" > force.csv
    tissuec export tube.vtkhdf energies events -o tube.csv
    tissuec export tube.vtkhdf --frame 0 -o tube.obj
    """
    from tissuec.results.export import export_csv, export_obj, export_vtu
    from tissuec.results.trajectory import Trajectory

    kind = kind or _kind(output)
    with Trajectory.open(result) as trajectory:
        if kind == "csv":
            names = list(logs) or [*trajectory.logs]
            if not names:
                raise TissueError(
                    f'"{result}" holds no logs; name "energies" or "events", or write a frame'
                )
            if output is None or str(output) == "-":
                export_csv(trajectory, names, sys.stdout)
            else:
                _to_file(output, lambda stream: export_csv(trajectory, names, stream))
            return DONE
        if output is None:
            raise click.UsageError(f"-o names the {kind.upper()} file to write")
        number = _frame(trajectory.times, frame, time)
        (export_vtu if kind == "vtu" else export_obj)(trajectory, number, output)
        settings.say(f"wrote frame {number} (t = {trajectory.times[number]:g} s) to {output}")
    return DONE


def _kind(output: Path | None) -> str:
    if output is None or str(output) == "-":
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


def _to_file(path: Path, write: Callable[[TextIO], object]) -> None:
    try:
        with open(path, "w", encoding="utf-8", newline="") as stream:
            write(stream)
    except OSError as error:
        raise cannot_write(path, error) from error
