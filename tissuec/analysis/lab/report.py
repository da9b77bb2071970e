"""The report on tissues in the laboratory: parts that follow each other, and plain data."""

from typing import Any

from tissuec.analysis.lab.rows import Examination, LabCurve, TestRow
from tissuec.compiler.provenance import curve_as_dict
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
