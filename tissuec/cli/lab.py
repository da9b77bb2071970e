"""``tissuec lab``: Test tissues in a virtual laboratory and compare with evidence."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tissuec.cli.arguments import OptionReader
from tissuec.cli.common import (
    DONE,
    FAILED,
    Command,
    Settings,
    echo,
    print_json,
    report,
    scene_options,
)
from tissuec.cli.completing import shipped_names
from tissuec.core.columns import aligned
from tissuec.core.errors import TissueError
from tissuec.core.units import LENGTH
from tissuec.view.plots.options import reader

if TYPE_CHECKING:
    from tissuec.analysis.lab.laboratory import Examination, TestRow

HEADS = ("test", "quantity", "coarse", "fine", "given", "known", "verdict")
LEAST = (14, 18, 12, 12, 12, 12)


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
@scene_options
def command(
    settings: Settings, file: str, tissue: str | None, thickness: float | None, spacing: float,
    out: Path | None, overrides: tuple[str, ...], libraries: tuple[Path, ...], strict: bool,
) -> int:  # fmt: skip
    """Test the tissues of FILE in a virtual laboratory.

    FILE is a file with tissues, a scene, or a shipped tissue such as liver. Each tissue is
    stretched, compressed, sheared, indented, torn and released on a coarse and on a fine
    coupon. The results are compared with the numbers of the tissue and with its evidence. Exit
    code 1: a measurement is more than 5 % (indentation: 15 %) outside the evidence, or the
    coupons differ by more than that.

    \b
    tissuec lab liver
    tissuec lab my_tissues.tis --tissue scar --out measured
    """
    from tissuec.analysis.lab.laboratory import chosen, examine
    from tissuec.pipeline import read_words
    from tissuec.scene.library import find_tissues
    from tissuec.scene.request import Request

    path = find_tissues(file, libraries)
    request = Request.file(path, overrides=overrides, libraries=libraries, strict=strict)
    words, warnings = read_words(request)
    if not settings.json:
        report(warnings, settings)
    found: list[Examination] = []
    for one in chosen(words, tissue, request.source):
        found.append(examine(request, one, spacing=spacing, thickness=thickness))
        if not settings.json:
            _print(found[-1])
    if out is not None:
        for name in _write(found, out):
            settings.say(f"wrote {name}")
    if settings.json:
        print_json({"ok": all(one.is_good for one in found), "tissues": [*map(as_dict, found)]})
    return DONE if all(one.is_good for one in found) else FAILED


def _write(found: "list[Examination]", folder: Path) -> "Iterator[Path]":
    """Write tables, and with matplotlib a picture of the curves; yield the files."""
    from tissuec.analysis.lab.tables import write_tables
    from tissuec.view.plots import draw
    from tissuec.view.plots.formats import save
    from tissuec.view.plots.page import need_matplotlib

    yield from write_tables(found, folder)
    try:
        need_matplotlib()
    except TissueError:
        return  # tables are there, and nothing said that a picture is needed
    document = {"tissues": [*map(as_dict, found)]}
    if any(map(len, (curves for one in found for curves in one.curves))):
        path = folder / "stress_strain.png"
        save(draw("stress-strain", document), path)
        yield path


def _print(found: "Examination") -> None:
    coupons = " and ".join(coupon.shown() for coupon in found.coupons)
    echo(f"\n{found.tissue.name}   ({found.tissue.span.place})   coupons of {coupons} cells")
    for line in aligned([HEADS, *map(_cells, found.rows)], LEAST):
        echo(f"  {line}")
    for note in found.notes:
        echo(f"  {note}")
    wrong = sum(not row.is_good for row in found.rows)
    echo(f"  {f'not good: {wrong} of {len(found.rows)} rows' if wrong else 'no contradiction'}")


def _cells(row: "TestRow") -> tuple[str, ...]:
    given = "" if row.given is None else row.shown(row.given)
    known = ", ".join(one.shown for one in row.known)
    values = (row.shown(row.coarse), row.shown(row.fine))
    return row.test, row.quantity, *values, given, known, row.verdict


def as_dict(found: "Examination") -> dict[str, Any]:
    """Return an examination as plain data, in SI units."""
    return {
        "tissue": found.tissue.name,
        "place": found.tissue.span.place,
        "ok": found.is_good,
        "coupons": [coupon.shown() for coupon in found.coupons],
        "rows": [
            {
                "test": row.test,
                "quantity": row.quantity,
                "coarse": row.coarse,
                "fine": row.fine,
                "given": row.given,
                "known": [
                    {"low": one.low, "high": one.high, "source": one.source,
                     "verified": one.is_verified, "place": one.span.place}
                    for one in row.known
                ],
                "verdict": row.verdict,
                "ok": row.is_good,
            }
            for row in found.rows
        ],
        "curves": {
            name: [{"strain": c.strain, "stress": c.stress} for c in curves]
            for name, curves in zip(("coarse", "fine"), found.curves, strict=True)
        },
        "notes": found.notes,
    }  # fmt: skip
