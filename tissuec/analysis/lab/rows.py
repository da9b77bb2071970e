"""Results of the laboratory: rows, curves, their comparison with evidence, and the report."""

import csv
from collections.abc import Iterable, Iterator, Sequence
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from msgspec import Struct, field

from tissuec.compiler.provenance import curve_as_dict
from tissuec.core.files import replacing
from tissuec.core.report import FactSection, FactTable
from tissuec.core.units import Dimension, show
from tissuec.model.network import Floats
from tissuec.scene.model import KnownQuantity, Tissue
from tissuec.scene.tissues.known_curves import ALONG, COMPRESSION, TENSION, KnownCurve
from tissuec.scene.tissues.quantities import TissueQuantity

SHARE = 0.05  # by which a measurement may be off
INSIDE = "inside the scatter"
#: Relative amount by which a strain may fall short of that of its load: more than statics
#: needs.
_REACHED = 1e-3


class StressStrainCurve(NamedTuple):
    """Stress against strain, both relative to the drawn shape.

    Attributes:
        strain: Ascending, shape (level,).
        stress: [Pa], shape (level,).
    """

    strain: Floats
    stress: Floats


class TestRow(Struct, frozen=True):
    """One quantity that a test measured.

    Attributes:
        test: Name of the test.
        quantity: The measured quantity.
        check: The same by an independent method, in SI units: the law of the tissue alone where
            the state is uniform, otherwise a coarser coupon; NaN if there is none.
        measured: The value in SI units; NaN where it was not measured.
        given: The number of the tissue, in SI units; None if it has none.
        known: Evidence on it.
        verdict: The contradiction; otherwise "good", or that it depends on the mesh.
        is_good: Whether it agrees with the evidence, and with the check.
        dimension: Dimension of the quantity.
    """

    test: str
    quantity: str
    check: float
    measured: float
    given: float | None
    known: tuple[KnownQuantity, ...]
    verdict: str
    is_good: bool
    dimension: Dimension

    def shown(self, value: float) -> str:
        """Return a value of this quantity with its unit."""
        return show(value, self.dimension, digits=4) if isfinite(value) else "-"


class LabCurve(Struct, frozen=True):
    """A measured curve, with the evidence on it.

    Attributes:
        mode: One of ``known_curves.MODES``; empty for a relaxation.
        place: Strains, or times [s], ascending, shape (place,).
        value: Nominal stresses [Pa], or remaining shares of the stress.
        check: The same by an independent method, as in rows; NaN if there is none.
        known: Evidence on it.
    """

    mode: str
    place: Floats
    value: Floats
    check: Floats
    known: tuple[KnownCurve, ...] = ()

    @property
    def stress_strain(self) -> StressStrainCurve:
        """Return strains and stresses, both negative in compression."""
        if self.mode == COMPRESSION:
            return StressStrainCurve(-self.place[::-1], -self.value[::-1])
        return StressStrainCurve(self.place, self.value)

    def at(self, place: float) -> tuple[float, float]:
        """Return the value and the check at a place; NaN beyond the measured range."""
        if len(self.place) == 0 or place > self.place[-1] * (1.0 + _REACHED):
            return np.nan, np.nan
        start = np.append(0.0, self.place), np.append(0.0 if self.mode else 1.0, self.value)
        check = np.append(start[1][0], self.check)
        return float(np.interp(place, *start)), float(np.interp(place, start[0], check))


class Examination(Struct):
    """Results of all tests of a tissue.

    Attributes:
        tissue: The tissue.
        coupons: Description of the specimens.
        rows: One for each quantity of each test, and for each known curve.
        curves: Measured curves.
        notes: Remarks on the measurements.
    """

    tissue: Tissue
    coupons: str
    rows: list[TestRow] = field(default_factory=list[TestRow])
    curves: list[LabCurve] = field(default_factory=list[LabCurve])
    notes: list[str] = field(default_factory=list[str])

    @property
    def is_good(self) -> bool:
        """Return whether all rows agree with the evidence and with their checks."""
        return all(row.is_good for row in self.rows)


def known_of(tissue: Tissue, mode: str) -> tuple[KnownCurve, ...]:
    """Return the evidence of a tissue on a curve.

    Args:
        mode: One of ``known_curves.MODES``; empty for a relaxation. Tension along fibres and
            tension are the same.
    """
    modes = (TENSION, ALONG) if mode in (TENSION, ALONG) else (mode,)
    return tuple(one for one in tissue.curves if one.mode in modes)


def agrees(value: float, known: KnownQuantity, share: float = SHARE) -> bool:
    """Return whether a measurement agrees with evidence within a relative deviation.

    Args:
        value: The measurement.
        known: The evidence.
        share: Allowed relative deviation of the measurement.
    """
    return _beyond(value, known.low, known.high, share) == 0.0


def _beyond(value: float, low: float, high: float, share: float = SHARE) -> float:
    """Return the relative distance of a value above or below a range; 0 within a deviation."""
    most = share * abs(value)
    if value > high + most:
        return value / high - 1.0
    return value / low - 1.0 if value < low - most else 0.0


def curve_rows(test: str, curve: LabCurve, why: str) -> Iterator[TestRow]:
    """Yield a row for each source on a curve: at its worst place, or at the last one.

    Args:
        test: Name of the test.
        curve: The measured curve.
        why: The reason why the curve ends before known places, such as "it tears".
    """
    for known in curve.known:
        reached = [place for place in known.places if isfinite(curve.at(place)[0])]
        off = [_off(curve, known, place) for place in reached]
        worst = int(np.argmax(np.abs(off))) if any(off) else len(off) - 1
        is_good = not any(off) and len(reached) == len(known.places)
        place = reached[worst] if reached else known.places[0]
        value, check = curve.at(place)
        verdict = INSIDE
        if any(off):
            side = "above" if off[worst] > 0.0 else "below"
            verdict = f'{100.0 * abs(off[worst]):.2g} % {side} "{known.source}"'
        elif not is_good:
            missed = next(one for one in known.places if one not in reached)
            verdict = f'not measured at {known.shown_place(missed)} of "{known.source}": {why}'
        yield TestRow(
            test, _name(known, place), check, value, None, (_limits(known, place),), verdict,
            is_good, known.dimension,
        )  # fmt: skip


def _off(curve: LabCurve, known: KnownCurve, place: float) -> float:
    limits = known.limits_at(place)
    assert limits is not None
    return _beyond(curve.at(place)[0], *limits)


def _name(known: KnownCurve, place: float) -> str:
    """Return the quantity of a row, such as "stress at 20 %"."""
    about = "stress" if known.mode else "stress left"
    return f"{about} at {known.shown_place(place)}"


def _limits(known: KnownCurve, place: float) -> KnownQuantity:
    """Return the evidence on a curve at one place as evidence on a quantity."""
    limits = known.limits_at(place)
    assert limits is not None
    quantity = TissueQuantity(_name(known, place), "", known.dimension)
    return KnownQuantity(quantity, limits, known.source, known.is_verified, known.span)


def joined(curves: Iterable[LabCurve], modes: Sequence[str]) -> StressStrainCurve:
    """Return the stresses of several modes over their strains as one curve, ascending."""
    parts = [one.stress_strain for one in curves if one.mode in modes]
    if not parts:
        return StressStrainCurve(np.zeros(0), np.zeros(0))
    strain = np.concatenate([one.strain for one in parts])
    order = np.argsort(strain, kind="stable")
    return StressStrainCurve(
        strain[order], np.concatenate([one.stress for one in parts])[order]
    )


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
