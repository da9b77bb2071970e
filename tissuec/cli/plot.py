"""``tissuec plot``: Plot results, vocabularies and benchmarks."""

from pathlib import Path
from typing import Any, cast

import click
from msgspec.structs import asdict, fields

from tissuec.cli.arguments import OptionReader
from tissuec.cli.common import Command, SceneOptions, Settings, keep_input, scene_options
from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.core.report import Fact, Report
from tissuec.view.plots import PLOTS, USUAL
from tissuec.view.plots.options import Option, options_of
from tissuec.view.plots.page import STYLES, style_named

SMALLEST, LARGEST = 30.0, 2000.0  # [mm]


def read_size(text: str) -> tuple[float, float]:
    """Return width and height of "160x100" [mm].

    Raises:
        ValueError: The text is no size, or the size is out of range.
    """
    try:
        width, height = (float(part) for part in text.lower().removesuffix("mm").split("x"))
    except ValueError:
        raise ValueError(f'"{text}" is not a size; write WIDTHxHEIGHT in mm: 160x100') from None
    if not (SMALLEST <= width <= LARGEST and SMALLEST <= height <= LARGEST):
        raise ValueError(
            f'"{text}": each side must be between {SMALLEST:g} mm and {LARGEST:g} mm'
        )
    return width, height


def read_kind(text: str) -> str:
    """Return a kind of plot.

    Raises:
        ValueError: There is no such kind.
    """
    if text not in PLOTS:
        hint = alternatives(text, PLOTS, what="kinds")
        raise ValueError(f'there is no kind of plot called "{text}"; {hint}')
    return text


def read_style(text: str) -> str:
    """Return the name of a style.

    Raises:
        ValueError: There is no such style.
    """
    try:
        style_named(text)
    except TissueError as error:
        raise ValueError(str(error)) from error
    return text


def plot_options(function: Any) -> Any:
    """Add the options of all kinds, each once."""
    found: dict[str, dict[str, Option]] = {}
    defaults: dict[str, Any] = {}
    for kind, member in PLOTS.items():
        defaults |= {field.name: field.default for field in fields(cast(Any, member))}
        for name, option in options_of(member).items():
            found.setdefault(name, {})[kind] = option
    for name in sorted(found, reverse=True):  # the last one applied comes first in the help
        function = _as_click(name, found[name], defaults[name])(function)
    return function


def _as_click(name: str, options: dict[str, Option], default: Any) -> Any:
    """Return an option with its meanings for the kinds that have it."""
    texts: dict[str, list[str]] = {}
    for kind, option in options.items():
        texts.setdefault(option.help, []).append(kind)
    text = " ".join(f"[{', '.join(kinds)}] {said}" for said, kinds in texts.items())
    one = next(iter(options.values()))
    spellings = one.spellings or (f"--{name}",)
    if isinstance(default, bool):
        return click.option(*spellings, name, is_flag=True, default=None, help=text)
    return click.option(
        *spellings, name, multiple=isinstance(default, tuple), type=OptionReader(one.read),
        metavar="|".join(dict.fromkeys(one.metavar for one in options.values())), help=text,
    )  # fmt: skip


@click.command(cls=Command)
@click.argument("files", nargs=-1, required=True)
@click.option(
    "--kind",
    type=OptionReader(read_kind),
    metavar="KIND",
    help=f"Kind of plot: {', '.join(PLOTS)}; by default chosen for the file.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Picture to write: .png, .svg, .pdf, .eps or .pgf; by default named after the file.",
)
@click.option(
    "--size",
    type=OptionReader(read_size),
    metavar="WIDTHxHEIGHT",
    help="Size of the picture, in mm.",
)
@click.option(
    "--dpi",
    type=click.IntRange(30, 1200),
    default=150,
    show_default=True,
    help="Resolution of a .png, in pixels per inch.",
)
@click.option("--title", default="", help="Title of the picture.")
@click.option(
    "--style",
    type=OptionReader(read_style),
    default="screen",
    metavar="|".join(STYLES),
    help="Look: paper is a column of a journal (85 mm, letters of 7 to 9 pt), paper-wide a "
    "page (180 mm).",
)
@plot_options
@scene_options
def command(
    settings: Settings,
    files: tuple[str, ...],
    kind: str | None,
    output: Path | None,
    size: tuple[float, float] | None,
    dpi: int,
    title: str,
    style: str,
    given: SceneOptions,
    **options: Any,
) -> Report:
    """Plot FILES: results, tables of studies, vocabularies, scenes, or the JSON of benchmarks.

    By default, the plot of a result is an overview, that of a table depends on the design of
    its study, a scene or vocabulary is plotted as its words, and a benchmark as a
    work-precision diagram. Logs, energies and paths of several results are plotted together.
    Numbers are in SI units or have a unit: --start 40ms.

    \b
    tissuec plot tube.vtkhdf
    tissuec plot a.vtkhdf b.vtkhdf --kind logs --log "force of forceps A" -o both.pdf
    tissuec plot fuzzy/soft_tissue --kind rules --x hardness --y elasticity
    tissuec plot lift.stretching.csv --kind response --measure pull
    """
    from tissuec.view.plots import WrongOption, draw
    from tissuec.view.plots.formats import check_suffix, save
    from tissuec.view.plots.page import need_matplotlib

    need_matplotlib()  # before all the work
    chosen = {name: value for name, value in options.items() if value not in (None, ())}
    if output is not None:
        check_suffix(output)
        for file in files:
            keep_input(output, Path(file))
    try:
        figure: Any = draw(
            kind, *files, size=size, title=title, style=style, **asdict(given), **chosen,
        )  # fmt: skip
    except WrongOption as error:
        raise click.UsageError(str(error)) from error
    target = output or _name(files[0], figure.kind)
    save(figure, target, dpi=dpi)
    width, height = (round(25.4 * side, 2) for side in figure.get_size_inches())
    document = {
        "file": target,
        "kind": figure.kind,
        "drawn_of": files,
        "size_mm": [width, height],
        "notes": figure.notes,
        **figure.numbers,
    }
    notes = [Fact("note", note) for note in figure.notes]
    return Report([*notes, f"wrote {target}"], document, level="remark")


def _name(file: str, kind: str) -> Path:
    """Return the picture of a file, in the current directory."""
    stem = Path(file).stem
    is_usual = any(kind == kinds[0] for kinds in USUAL.values())
    return Path(f"{stem}.png" if is_usual else f"{stem}.{kind}.png")
