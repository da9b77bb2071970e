"""``tissuec view``: Play results in a browser page, or draw them as pictures."""

import re
import shlex
import sys
from collections.abc import Callable, Iterable, Iterator
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import click
from msgspec import Struct

from tissuec.cli.arguments import LateChoice, OptionReader, Pair, TimeArgument
from tissuec.cli.common import (
    Command,
    Reports,
    Settings,
    check_page_name,
    keep_input,
    show_page,
)
from tissuec.core.errors import TissueError, counted, shown_size
from tissuec.core.files import replacing, write_file
from tissuec.core.prefixes import shown_units
from tissuec.core.report import Part, Report
from tissuec.core.units import NUMBER, TIME, Unit, UnitError, parse_unit, show
from tissuec.view.player.fields import TISSUE, NodeField, known_fields
from tissuec.view.player.options import COLOURS, Options
from tissuec.view.section import read_plane

if TYPE_CHECKING:
    from tissuec.results.trajectory import Trajectory
    from tissuec.view.player.film import PlayerData

#: Options that draw pictures -> the end of their files.
PICTURES = {"png": ".png", "gif": ".gif", "mp4": ".mp4"}
RESULTS = (".vtkhdf", ".h5", ".hdf5")
SIZES = {"png": (1280, 720), "gif": (640, 360), "mp4": (1280, 720)}
_LARGEST = 8192  # [px]
_HEAVY = 25_000_000  # bytes of a page
_MARK = b'name="generator" content="tissuec'

F = TypeVar("F", bound=Callable[..., Any])


def _picture(name: str, text: str) -> Callable[[F], F]:
    kind = click.Path(path_type=Path, dir_okay=False)
    return click.option(f"--{name}", type=kind, help=text)


class ViewCommand(Command):
    """``view``, whose options of pictures take the name of the picture."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the command line.

        Raises:
            UsageError: An option of a picture is not followed by the name of a picture.
        """
        written = tuple(args)  # which click uses up
        try:
            return super().parse_args(ctx, args)
        except click.UsageError as error:
            if usage := _without_picture(written):
                raise click.UsageError(usage, ctx) from error
            raise


def _without_picture(written: tuple[str, ...]) -> str:
    """Return the full command for a picture option that lacks its file name."""
    for place, word in enumerate(written):
        name = word.removeprefix("--")
        if word not in {f"--{one}" for one in PICTURES}:
            continue
        behind = written[place + 1 : place + 2]
        if behind and Path(behind[0]).suffix.lower() == PICTURES[name]:
            continue
        others = [one for one in written if not one.startswith("-")]
        result = Path(next((one for one in others if Path(one).suffix in RESULTS), "RESULT"))
        return _named_behind(name, result, others)
    return ""


def _named_behind(name: str, result: Path, others: Iterable[str]) -> str:
    """Return an error for an option that takes the name of a picture, with the whole command.

    Args:
        name: Of the option.
        result: What is drawn.
        others: What else was written; the name of the picture may be among it.
    """
    end = PICTURES[name]
    named = (one for one in others if Path(one).suffix.lower() == end)
    picture = next(named, f"{result.stem}{end}")
    words = ["tissuec", "view", str(result), f"--{name}", picture]
    return f"--{name} takes the picture to write, which ends in {end}: {shlex.join(words)}"


@click.command(cls=ViewCommand)
@click.argument("results", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Page to write (one result only).",
)
@click.option("--frames", type=click.IntRange(min=2), help="Maximum number of frames.")
@click.option(
    "--every", type=TimeArgument(), help='Minimum time between frames, such as "20 ms".'
)
@click.option(
    "--nodes",
    type=click.IntRange(min=10),
    help="Approximate number of nodes to draw of a larger net, evenly distributed.",
)
@click.option(
    "--colour",
    type=click.Choice(COLOURS),
    help="Show springs, coloured by this quantity.",
)
@click.option(
    "--field",
    type=LateChoice(lambda: (TISSUE, *known_fields())),
    help="Colour the skin by this field; by its tissues if not given.",
)
@click.option(
    "--range",
    metavar="LOW,HIGH",
    help='Range of the colours of the field, such as "0,2 mm"; without the largest 2 % of all '
    "nodes if not given.",
)
@click.option(
    "--scale",
    type=click.Choice(("linear", "log")),
    help="Whether the colours of the field follow its numbers or their logarithms.",
)
@click.option(
    "--time", type=TimeArgument(), help="Initial time of the page, or time of the picture."
)
@click.option(
    "--from",
    "view",
    type=Pair(",", "AZIMUTH,ELEVATION", -360.0, 360.0),
    help="Direction of view in degrees: -90,0 is from the front, -90,90 from above.",
)
@click.option(
    "--section",
    type=OptionReader(read_plane),
    metavar="PLANE",
    help='Cut bodies open by a plane and hide the side towards the viewer: "z = 6 mm", or '
    '"through (0, 0, 6) mm facing (0, 1, 1)".',
)
@click.option(
    "--speed",
    type=click.FloatRange(min=0.0, min_open=True),
    help="Playback speed (1 is real time); chosen automatically if not given.",
)
@_picture("png", "Draw one frame to this file, by default the last one.")
@_picture("gif", "Draw all frames to this file, as an animated GIF.")
@_picture("mp4", "Draw all frames to this file, as a video; needs ffmpeg.")
@click.option(
    "--size",
    type=Pair("x", "WIDTHxHEIGHT", 16, _LARGEST),
    help="Size of pictures in pixels; default 1280x720, for a GIF 640x360.",
)
@click.option("--forces", is_flag=True, help="Draw the forces on nodes in pictures.")
@click.option("--open", "opens", is_flag=True, help="Open the page in your browser.")
def command(
    settings: Settings,
    results: tuple[Path, ...],
    output: Path | None,
    size: tuple[float, float] | None,
    forces: bool,
    opens: bool,
    **chosen: Any,
) -> Reports:
    """Write pages that play RESULTS; tube.vtkhdf gives tube.html in the current directory.

    A page is one file that any browser opens, without a network. It replaces an earlier page,
    but no other file. Pictures need the extra plot, but no browser.

    \b
    tissuec view tube.vtkhdf --open
    tissuec view tube.vtkhdf --png tube.png --time 0.8
    tissuec view large.vtkhdf --nodes 5000 --every "20 ms" -o large.html
    """
    pictures = {name: chosen.pop(name) for name in PICTURES}
    pictures = {name: path for name, path in pictures.items() if path is not None}
    _check_usage(results, output, pictures, size=size, forces=forces, opens=opens)
    chosen["range"] = _range(chosen["range"], chosen["field"])
    scale = chosen.pop("scale")
    if scale and chosen["field"] in (None, TISSUE):
        raise click.UsageError("--scale needs a field: --field stress --scale log")
    chosen["logarithmic"] = scale == "log"
    options = Options(**chosen, cells=output is not None or not pictures)
    if options.every is not None and options.every <= 0.0:
        raise click.UsageError("--every must be above 0")
    pages = {} if pictures and output is None else _pages(results, output)
    for path in (*pages.values(), *pictures.values()):
        for result in results:
            keep_input(path, result)
    wish = ViewOptions(options, pictures, size, forces)

    def each() -> Iterator[Report]:
        for result in results:
            page = pages.get(result)
            if page is not None:
                _check_replaceable(page)
            yield _show(result, page, wish, settings)
            if opens and page is not None:
                show_page(page)

    return Reports(each(), len(results) > 1)


def _range(text: str | None, name: str | None) -> tuple[float, float] | None:
    """Return the range of a field, in its SI unit."""
    if text is None:
        return None
    field = known_fields().get(name or "")
    if field is None:
        raise click.UsageError(
            f'--range needs the field whose colours it limits: --field strain --range "{text}"'
        )
    try:
        return field_range(text, field)
    except ValueError as error:
        raise click.BadParameter(str(error), param_hint="'--range'") from error


def _check_usage(
    results: tuple[Path, ...],
    output: Path | None,
    pictures: dict[str, Path],
    *,
    size: tuple[float, float] | None,
    forces: bool,
    opens: bool,
) -> None:
    """Refuse options that do not go together."""
    for name, path in pictures.items():
        if path.suffix.lower() != PICTURES[name]:
            given = [str(one) for one in (*results, path, *([output] if output else []))]
            result = next((one for one in given if Path(one).suffix in RESULTS), given[0])
            raise click.UsageError(_named_behind(name, Path(result), given))
    if len(results) > 1 and (output is not None or pictures):
        name = "-o" if output is not None else f"--{next(iter(pictures))}"
        raise click.UsageError(f"{name} is for one result; give one result")
    if output is not None:
        kind = next((k for k, end in PICTURES.items() if end == output.suffix.lower()), "")
        instead = (
            f"for a picture write --{kind} {output}"
            if kind
            else ("for pictures use --png, --gif and --mp4")
        )
        check_page_name(output, instead)
    for option, is_given in (("--size", size is not None), ("--forces", forces)):
        if is_given and not pictures:
            raise click.UsageError(f"{option} is for pictures: --png, --gif and --mp4")
    if opens and pictures and output is None:
        raise click.UsageError("--open needs a page; name it with -o")


def _pages(results: tuple[Path, ...], output: Path | None) -> dict[Path, Path]:
    """Return where the page of each result goes; TissueError if two would be one."""
    pages: dict[Path, Path] = {}
    for result in results:
        page = output or Path(f"{result.stem or 'result'}.html")
        other = next((one for one, place in pages.items() if place == page), None)
        if other is not None and other != result:
            raise TissueError(
                f'the pages of "{other}" and "{result}" would both be "{page}"; write one of '
                "them separately, with -o"
            )
        pages[result] = page
    return pages


def _check_replaceable(page: Path) -> None:
    """Check that a page replaces only pages of tissuec; TissueError."""
    if not page.exists() or not page.is_file() or not page.stat().st_size:
        return
    with open(page, "rb") as file:
        if _MARK not in file.read(1024):
            raise TissueError(
                f'cannot write "{page}": it exists and is not a page of tissuec; name '
                "another file with -o, or remove it"
            )


class ViewOptions(Struct, frozen=True):
    """The outputs for each result.

    Attributes:
        options: How it is shown.
        pictures: Files to draw, by their kinds.
        size: Of these [px]; None for what is usual.
        forces: Whether forces on nodes are drawn there.
    """

    options: Options
    pictures: dict[str, Path]
    size: tuple[float, float] | None
    forces: bool


def _show(result: Path, page: Path | None, wish: ViewOptions, settings: Settings) -> Report:
    """Write the requested files of one result, and return the report."""
    from tissuec.results.trajectory import Trajectory
    from tissuec.view.player.reading import read_film

    _check_extras(wish.pictures)
    with Trajectory.open(result) as trajectory:
        film = read_film(trajectory, wish.options)
        parts = _check_section(film, trajectory, wish)
        document: dict[str, Any] = {
            "result": str(result),
            "frames": film.frame_count,
            "nodes": film.node_count,
            "springs": len(film.lines.ends),
        }
        if page is not None:
            document["page"], said = _write_page(page, film, trajectory, wish.options)
            parts += said
        for kind, path in wish.pictures.items():
            document[kind], said = _draw(kind, path, film, trajectory, wish, settings)
            parts += said
    return Report(parts, document, level="remark")


def _check_section(
    film: "PlayerData", trajectory: "Trajectory", wish: "ViewOptions"
) -> list[Part]:
    """Check that a section meets bodies when they are shown; return notes on hollow bodies."""
    from tissuec.view.section.cross_section import check_plane

    plane, time = wish.options.section, wish.options.time
    if plane is None:
        return []
    last = time is None and "png" in wish.pictures
    still = float(film.times[-1]) if last else time
    check_plane(film, plane, None if still is None else film.moment_at(still))
    bodies = [body.name for body in trajectory.network.bodies]
    hollow = [name for name in bodies if name not in film.cells.filled]
    if not hollow:
        return []
    verb = "is" if len(hollow) == 1 else "are"
    return [f"note: {', '.join(hollow)} {verb} not filled: cut open without a cut face"]


def _check_extras(pictures: dict[str, Path]) -> None:
    """Raise TissueError for missing packages before any work is done."""
    if "mp4" in pictures:  # first: the extra that brings it brings what the others need
        from tissuec.view.player.files import need_ffmpeg

        need_ffmpeg()
    if pictures:
        from tissuec.view.plots.page import need_matplotlib

        need_matplotlib()


def _write_page(
    page: Path, film: "PlayerData", trajectory: "Trajectory", options: Options
) -> tuple[dict[str, Any], list[Part]]:
    from tissuec.view.player.page import render_film

    data = render_film(film, trajectory, options).encode("utf-8")
    write_file(page, data)
    parts: list[Part] = [
        f"wrote {page}: {counted(film.frame_count, 'frame')}, {shown_size(len(data))}"
    ]
    if len(data) > _HEAVY:
        parts.append("  --nodes 10000 or --frames 50 reduces the size")
    return {"file": str(page), "bytes": len(data)}, parts


def _draw(
    kind: str,
    path: Path,
    film: "PlayerData",
    trajectory: "Trajectory",
    wish: ViewOptions,
    settings: Settings,
) -> tuple[dict[str, Any], list[Part]]:
    from tissuec.view.player.drawn_nodes import DrawnNodes
    from tissuec.view.player.facts import thinning, title
    from tissuec.view.player.files import write_gif, write_video
    from tissuec.view.player.node_values import chosen_field
    from tissuec.view.player.picture import Painter
    from tissuec.view.plots.formats import metadata
    from tissuec.view.plots.subjects import PlotSubject, credits_of

    width, height = map(int, wish.size or SIZES[kind])
    options = wish.options
    field = chosen_field(DrawnNodes(film, trajectory), options)
    painter = Painter(
        film, options, (width, height), title(trajectory), forces=wish.forces, field=field
    )
    left_out = [f"  {thinned}"] if (thinned := thinning(film)) else []
    if kind == "png":
        at = film.moment_at(film.times[-1] if options.time is None else options.time)
        time, picture = film.time_at(at), cast("Any", painter.draw(at))
        with replacing(path) as beside:
            subject = PlotSubject("result", painter.title, trajectory)
            known = metadata(".png", credits_of(subject)) | {"Software": "tissuec"}
            picture.savefig(beside, format="png", metadata=known)
        said = f"wrote {path}: t = {show(time, TIME)}"
        return {"file": str(path), "time": time}, [said, *left_out]
    write = write_gif if kind == "gif" else write_video
    pictures = write(painter, path, options.speed, _progress(settings))
    said = f"wrote {path}: {counted(pictures, 'picture')}, {shown_size(path.stat().st_size)}"
    return {"file": str(path), "pictures": pictures}, [said, *left_out]


def _progress(settings: Settings) -> Callable[[int, int], None]:
    """Return the function that shows at a terminal which picture is drawn."""
    if settings.quiet or not sys.stderr.isatty():
        return lambda number, count: None
    clear = "\r\033[K"
    return lambda number, count: click.echo(  # as it is: it moves the cursor
        clear if number + 1 == count else f"\rpicture {number + 1} of {count}",
        nl=False,
        err=True,
    )


_NUMBER = r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\s*((?!to\b)[^\s,\d.+…-][^,.…]*?)?\s*"
_RANGE = re.compile(rf"{_NUMBER}(?:,|\.\.\.?|…|\bto\b){_NUMBER}", re.IGNORECASE)


def field_range(text: str, field: NodeField) -> tuple[float, float]:
    """Return the range that a text states, in the SI unit of a field.

    The unit of the second number is that of the first one too, unless that has its own.

    Args:
        text: Such as "0,2 mm", "-5 %,5 %" or "0 .. 20 %".

    Raises:
        ValueError: It is none; says what to write.
    """
    example = f'write --range "0,{_round(field)}"'
    found = _RANGE.fullmatch(text)
    if found is None:
        raise ValueError(f'"{text}" does not have the form LOW,HIGH; {example}')
    low, high = (
        _size(float(number), unit or found[4] or "", field, example)
        for number, unit in ((found[1], found[2]), (found[3], found[4]))
    )
    if not low < high:
        raise ValueError(f'the first number of "{text}" must be smaller than the second')
    return low, high


def _size(value: float, unit: str, field: NodeField, example: str) -> float:
    if not unit and value != 0.0:
        raise ValueError(f"a range of {field.name} needs a unit; {example}")
    try:
        given = parse_unit(unit) if unit else _own(field)
    except UnitError as error:
        raise ValueError(f"{error}; {example}") from error
    if given.dimension != _own(field).dimension:
        raise ValueError(f'"{unit}" is not a unit of {field.name}; {example}')
    size = value * given.factor
    if not isfinite(size):
        raise ValueError(f"a number of this range is too large; {example}")
    return size


def _own(field: NodeField) -> Unit:
    return parse_unit(field.unit) if field.unit else Unit(1.0, NUMBER)


def _round(field: NodeField) -> str:
    """Return a number with a unit that people use for a field."""
    if not field.unit:
        return "20 %"
    small = [one.unit for one in shown_units(field.unit) if one.unit.startswith(("m", "k"))]
    return f"2 {next((unit for unit in small if unit != field.unit), field.unit)}"
