"""Results of the laboratory as CSV files."""

import csv
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from tissuec.analysis.lab.rows import Examination, LabCurve
from tissuec.core.files import replacing

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
