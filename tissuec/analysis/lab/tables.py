"""Results of the laboratory as CSV files."""

import csv
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from tissuec.analysis.lab.laboratory import Examination
from tissuec.core.files import replacing

_HEADS = (
    "test",
    "quantity",
    "coarse",
    "fine",
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
        for name, curves in zip(("coarse", "fine"), one.curves, strict=True):
            points = [point for curve in curves for point in zip(*curve, strict=True)]
            path = folder / f"{stem}_{name}_curve.csv"
            yield _written(path, ("strain", "stress_Pa"), sorted(points))


def _rows(found: Examination) -> Iterator[tuple[object, ...]]:
    for row in found.rows:
        low = max((one.low for one in row.known), default="")
        high = min((one.high for one in row.known), default="")
        sources = "; ".join(one.source for one in row.known)
        given = "" if row.given is None else row.given
        values = (row.coarse, row.fine, given, low, high, sources, row.verdict)
        yield row.test, row.quantity, *values


def _written(path: Path, heads: Sequence[str], rows: Iterable[tuple[object, ...]]) -> Path:
    with replacing(path) as beside, beside.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(heads)
        writer.writerows(rows)
    return path
