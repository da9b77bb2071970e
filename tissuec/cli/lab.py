"""``tissuec lab``: Test tissues in a virtual laboratory and compare with evidence."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from tissuec.cli.arguments import OptionReader
from tissuec.cli.common import (
    Command,
    SceneOptions,
    Settings,
    check_page_name,
    keep_input,
    scene_options,
)
from tissuec.cli.completing import shipped_names
from tissuec.core.errors import TissueError
from tissuec.core.files import write_file
from tissuec.core.report import DONE, FAILED, Fact, Report
from tissuec.core.units import LENGTH
from tissuec.view.plots.options import reader

if TYPE_CHECKING:
    from tissuec.analysis.lab.rows import Examination
    from tissuec.scene.model import Tissue
    from tissuec.scene.request import Request
    from tissuec.scene.resolve import ResolvedProgram


def _length(text: str) -> float:
    found: float = reader(LENGTH)(text)
    if found <= 0.0:
        raise ValueError("it must be above 0 m")
    return found


@click.command(cls=Command)
@click.argument("file", shell_complete=shipped_names("matter", "tissues", short=True))
@click.option("--tissue", metavar="NAME", help="Test this tissue only.")
@click.option(
    "--thickness",
    metavar="LENGTH",
    type=OptionReader(_length),
    help='Test strips of a sheet of this thickness, such as "1 mm", instead of bars.',
)
@click.option(
    "--spacing",
    metavar="LENGTH",
    type=OptionReader(_length),
    default="2.5 mm",
    show_default=True,
    help="Length of cells, for tissues whose quantities belong to springs.",
)
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    help="Write the table and the stress-strain curves to this folder: CSV, and a picture "
    "if matplotlib is installed.",
)
@click.option(
    "--page",
    type=click.Path(path_type=Path),
    help="Write a page about all of these tissues: words, numbers with their sources, curves "
    "with the scatter of the sources, measurements. It is searchable and needs no network.",
)
@scene_options
def command(
    settings: Settings, file: str, tissue: str | None, thickness: float | None, spacing: float,
    out: Path | None, page: Path | None, given: SceneOptions,
) -> Report:  # fmt: skip
    """Test the tissues of FILE in a virtual laboratory.

    FILE is a file with tissues, a scene, a shipped tissue such as liver, or a folder of such
    files, such as matter, the folder of the shipped tissues. Each tissue is stretched,
    compressed, sheared, indented, torn, held and released. The results are compared with the
    numbers of the tissue, with its evidence, and with an independent check: the closed form of
    its law, or a coarser mesh. Exit code 1: a measurement is more than 5 % (indentation: 15 %)
    outside the evidence, or differs from the check by more than that.

    \b
    tissuec lab liver
    tissuec lab my_tissues.tis --tissue scar --out measured
    tissuec lab matter --page atlas.html
    """
    from tissuec.analysis.lab.rows import as_dict
    from tissuec.pipeline import read_words

    if page is not None:
        check_page_name(page)
    paths = _files(file, given.libraries)
    if page is not None:
        for path in paths:
            keep_input(page, path)
    found: list[Examination] = []
    for path in paths:
        request = given.request(path)
        words, warnings = read_words(request)
        settings.warn(warnings)
        chosen = _chosen(words, tissue, request, is_single=len(paths) == 1)
        found += [_examined(request, one, spacing, thickness, settings) for one in chosen]
    if not found:
        named = f' tissue "{tissue}"' if tissue else " a tissue"
        raise TissueError(f'no file of "{file}" declares{named}')
    written = [*_write(found, out)] if out is not None else []
    if page is not None:
        written.append(_write_page(found, page, f"Atlas of {file}" if len(paths) > 1 else ""))
    parts = [Fact("", f"wrote {name}", "remark") for name in written]
    document = {"tissues": [*map(as_dict, found)], "written": [*map(str, written)]}
    return Report(parts, document, DONE if all(one.is_good for one in found) else FAILED)


def _examined(
    request: "Request",
    tissue: "Tissue",
    spacing: float,
    thickness: float | None,
    settings: Settings,
) -> "Examination":
    """Return the results of a tissue; show each row once it is measured."""
    from tissuec.analysis.lab import laboratory, rows

    settings.show(rows.head(tissue))
    found = laboratory.examine(
        request, tissue, spacing=spacing, thickness=thickness,
        listener=lambda row: settings.show(rows.shown_row(row)),
    )  # fmt: skip
    settings.show(rows.end(found))
    return found


def _write_page(found: "list[Examination]", page: Path, title: str) -> Path:
    """Write the page about tissues; by default, its title names them."""
    from tissuec.view.report.atlas import render

    write_file(page, render(found, title or ", ".join(one.tissue.name for one in found)))
    return page


def _files(file: str, libraries: tuple[Path, ...]) -> list[Path]:
    """Return the selected files: one, or all in a folder, which can be in a library."""
    from tissuec.core.resources import library
    from tissuec.scene.program.library import find_tissues

    folders = (Path(file), *(folder / file for folder in (*libraries, library())))
    folder = next((one for one in folders if one.is_dir()), None)
    if folder is None:
        return [find_tissues(file, libraries)]
    found = sorted(folder.glob("*.tis"))
    if not found:
        raise TissueError(f'there is no file with tissues in the folder "{folder}"')
    return found


def _chosen(
    words: "ResolvedProgram", tissue: str | None, request: "Request", *, is_single: bool
) -> "list[Tissue]":
    """Return the tissues of a file; if there are several files, some may have none."""
    from tissuec.analysis.lab.laboratory import chosen

    try:
        return chosen(words, tissue, request.source)
    except TissueError:
        if is_single:
            raise
        return []


def _write(found: "list[Examination]", folder: Path) -> "Iterator[Path]":
    """Write tables, and with matplotlib a picture of the curves; yield the files."""
    from tissuec.analysis.lab.rows import as_dict, write_tables
    from tissuec.view.plots import draw
    from tissuec.view.plots.formats import save
    from tissuec.view.plots.page import need_matplotlib

    yield from write_tables(found, folder)
    try:
        need_matplotlib()
    except TissueError:
        return  # tables are there, and nothing said that a picture is needed
    document = {"tissues": [*map(as_dict, found)]}
    if any(one.curves for one in found):
        path = folder / "stress_strain.png"
        save(draw("stress-strain", document), path)
        yield path
