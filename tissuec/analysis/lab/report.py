"""Results of the laboratory: the report on tissues, plain data, and CSV files."""

import csv
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from tissuec.analysis.lab.rows import Examination, LabCurve, TestRow
from tissuec.compiler.provenance import curve_as_dict
from tissuec.core.files import replacing
from tissuec.core.report import FactSection, FactTable
from tissuec.scene.model import Tissue

HEADS = ("test", "quantity", "measured", "check", "given", "known", "verdict")
WIDTHS = (21, 20, 13, 13, 13, 26)  # of columns, before their cells are known


def head(tissue: Tissue) -> FactSection:
    """Return the beginning of the table of a tissue."""
    return FactSection(f"{tissue.name}   ({tissue.span.place})", [_table(HEADS)])


def shown_row(row: TestRow) -> FactSection:
    """Return the next row of the table."""
    given = "" if row.given is None else row.shown(row.given)
    known = ", ".join(one.shown for one in row.known)
    values = (row.shown(row.measured), row.shown(row.check))
    return FactSection(
        "", [_table((row.test, row.quantity, *values, given, known, row.verdict))]
    )


def _table(cells: tuple[str, ...]) -> FactTable:
    return FactTable((), [cells], least=WIDTHS)


def end(found: Examination) -> FactSection:
    """Return the text after the table: notes, and how many rows contradict."""
    wrong = sum(not row.is_good for row in found.rows)
    last = f"not good: {wrong} of {len(found.rows)} rows" if wrong else "no contradiction"
    return FactSection("", [*found.notes, last])


def as_dict(found: Examination) -> dict[str, Any]:
    """Return an examination as plain data, in SI units."""
    return {
        "tissue": found.tissue.name,
        "place": found.tissue.span.place,
        "ok": found.is_good,
        "coupons": found.coupons,
        "rows": [
            {
                "test": row.test,
                "quantity": row.quantity,
                "measured": row.measured,
                "check": row.check,
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
        "curves": [_curve(curve) for curve in found.curves],
        "notes": found.notes,
    }  # fmt: skip


def _curve(curve: LabCurve) -> dict[str, Any]:
    return {
        "mode": curve.mode or "relaxation",
        "place": curve.place,
        "value": curve.value,
        "check": curve.check,
        "known": [curve_as_dict(one) for one in curve.known],
    }


_HEADS = (
    "test",
    "quantity",
    "measured",
    "check",
    "given",
    "known_from",
    "known_to",
    "source",
    "verdict",
)


def write_tables(found: Sequence[Examination], folder: Path) -> Iterator[Path]:
    """Write the rows and curves of each tissue to a folder, in SI units; yield the files."""
    folder.mkdir(parents=True, exist_ok=True)
    for one in found:
        stem = "_".join(one.tissue.name.split())
        yield _written(folder / f"{stem}_table.csv", _HEADS, _rows(one))
        for curve in one.curves:
            name = "_".join((curve.mode or "relaxation").split())
            heads = ("strain", "stress_Pa", "check_Pa", "known_from_Pa", "known_to_Pa")
            if not curve.mode:
                heads = ("time_s", "left", "check", "known_from", "known_to")
            yield _written(folder / f"{stem}_{name}.csv", heads, _points(curve))


def _rows(found: Examination) -> Iterator[tuple[object, ...]]:
    for row in found.rows:
        low = max((one.low for one in row.known), default="")
        high = min((one.high for one in row.known), default="")
        sources = "; ".join(one.source for one in row.known)
        given = "" if row.given is None else row.given
        values = (row.measured, row.check, given, low, high, sources, row.verdict)
        yield row.test, row.quantity, *values


def _points(curve: LabCurve) -> Iterator[tuple[object, ...]]:
    """Yield the points of a curve, with the narrowest known limits there."""
    for point in zip(curve.place, curve.value, curve.check, strict=True):
        limits = [found for one in curve.known if (found := one.limits_at(point[0]))]
        low = max((one[0] for one in limits), default="")
        high = min((one[1] for one in limits), default="")
        yield *point, low, high


def _written(path: Path, heads: Sequence[str], rows: Iterable[tuple[object, ...]]) -> Path:
    with replacing(path) as beside, beside.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(heads)
        writer.writerows(rows)
    return path
