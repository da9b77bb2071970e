"""Tables of studies in files, and their columns for other programs."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.scene.study.model import Cell
from tissuec.studies.table import Column, MeasureCurve, StudyTable, title


def read_table(path: Path) -> StudyTable:
    """Return the table of a study, also of one that is not finished.

    Args:
        path: A file in CSV, or in HDF5 if its name ends with ".h5" or ".hdf5".

    Raises:
        ResultError: It cannot be read, or is not a table of a study.
    """
    if is_hdf5(path):
        from tissuec.studies.table_hdf5 import read_hdf5

        return read_hdf5(path)
    from tissuec.studies.table_text import read_csv

    return read_csv(path)


def is_table(path: Path) -> bool:
    """Return whether the name of a file is one that tables of studies have."""
    return path.suffix.lower() == ".csv" or is_hdf5(path)


def is_hdf5(path: Path) -> bool:
    """Return whether the name of a table says that it is in HDF5."""
    return path.suffix.lower() in (".h5", ".hdf5")


class Export(Struct, frozen=True):
    """Rows that are written.

    Attributes:
        heads: Of the columns, with units.
        rows: Numbers, words, and None where there is nothing.
    """

    heads: tuple[str, ...]
    rows: tuple[tuple[Cell | None, ...], ...]


def export(table: StudyTable, names: Sequence[str] = ()) -> Export:
    """Return the factors of a table, measures and curves, and the outcomes.

    With curves, there is a row for each sample of a run, which repeats what has one value.

    Args:
        names: Of measures and curves; all measures if none is named.

    Raises:
        TissueError: There is no such measure, or curves have different times.
    """
    chosen = [_named(table, name) for name in names] or list(table.measures)
    curves = [one for one in chosen if isinstance(one, MeasureCurve)]
    if len({curve.every for curve in curves}) > 1:
        written = ", ".join(f'"{one.name}" every {one.every:g} s' for one in curves)
        raise TissueError(f"curves of one file need the same times: {written}")
    heads = [factor.title for factor in table.factors]
    heads += ["time [s]"] if curves else []
    heads += [title(one.name, one.unit) for one in chosen]
    return Export(("run", *heads, "outcome"), tuple(_rows(table, chosen, curves)))


def _named(table: StudyTable, name: str) -> Column | MeasureCurve:
    known = {key_of(one.name): one for one in (*table.measures, *table.curves)}
    if key_of(name) not in known:
        hint = alternatives(name, [one.name for one in known.values()], what="there are")
        raise TissueError(f'the table has no measure "{name}"; {hint or "it has none"}')
    return known[key_of(name)]


def _rows(
    table: StudyTable, chosen: Sequence[Column | MeasureCurve], curves: Sequence[MeasureCurve]
) -> Iterator[tuple[Cell | None, ...]]:
    """Yield all rows; a run without a sample has one, which is empty there."""
    for row, run in enumerate(table.runs.tolist()):
        factors = [_cell(factor.values[row]) for factor in table.factors]
        samples: list[int | None] = [*_samples(curves, row)] or [None]
        for sample in samples:
            time = [None if sample is None else curves[0].times[sample].item()][: len(curves)]
            values = (_value(one, row, sample) for one in chosen)
            yield (run, *factors, *time, *values, table.outcome[row])


def _samples(curves: Sequence[MeasureCurve], row: int) -> list[int]:
    """Return the samples of a run that have a number in any curve."""
    known = [np.flatnonzero(np.isfinite(curve.values[row])) for curve in curves]
    return np.unique(np.concatenate(known)).tolist() if known else []


def _value(one: Column | MeasureCurve, row: int, sample: int | None) -> Cell | None:
    if isinstance(one, Column):
        return _cell(one.values[row])
    is_there = sample is not None and sample < one.values.shape[1]
    return _cell(float(one.values[row, sample])) if is_there else None


def _cell(value: Cell) -> Cell | None:
    if isinstance(value, str):
        return value
    return float(value) if np.isfinite(value) else None
