"""Tables of studies as HDF5: a dataset for each column; and for pandas and xarray."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import msgspec
import numpy as np
from numpy.typing import NDArray

from tissuec.core.files import replacing
from tissuec.model.network import Floats
from tissuec.results import ResultError
from tissuec.results.conversion import package
from tissuec.results.hdf5 import TEXT, open_file
from tissuec.studies.table import Column, MeasureCurve, StudyHead, StudyTable

if TYPE_CHECKING:
    import pandas  # pyright: ignore[reportMissingImports, reportMissingTypeStubs]
    import xarray  # pyright: ignore[reportMissingImports]

FORMAT = 1
_HEAD = "study"
_TEXTS = ("outcome", "reason", "promise", "digests")


def write_hdf5(table: StudyTable, path: Path) -> None:
    """Write a table, in place of a file of that name.

    Raises:
        ResultError: It cannot be written.
    """
    try:
        with replacing(path) as beside, open_file(beside, "w") as file:
            _write(table, file)
    except OSError as error:
        raise ResultError(f'cannot write "{path}": {error}') from error


def _write(table: StudyTable, file: h5py.File) -> None:
    facts = {"format": FORMAT, **msgspec.to_builtins(table.head)}
    file.attrs[_HEAD] = json.dumps(facts, ensure_ascii=False)
    file["runs"], file["error"] = table.runs, table.error
    for name in _TEXTS:
        _add_texts(file, name, getattr(table, name))
    file["end"] = table.end
    file["end"].attrs["unit"] = "s"
    if any(table.doubts):
        _add_texts(file, "doubts", table.doubts)
    for kind in ("factors", "measures", "curves"):
        group = file.create_group(kind)
        for column in getattr(table, kind):
            _add_column(group, column)


def _add_column(group: h5py.Group, column: Column | MeasureCurve) -> None:
    name = column.name.replace("/", "∕")  # a slash would open a group
    if isinstance(column.values, tuple):
        _add_texts(group, name, column.values)
    else:
        group[name] = column.values
    group[name].attrs["name"], group[name].attrs["unit"] = column.name, column.unit
    if isinstance(column, MeasureCurve):
        group[name].attrs["every"] = column.every


def _add_texts(group: h5py.Group, name: str, texts: tuple[str, ...]) -> None:
    group.create_dataset(name, data=np.array(texts, dtype=object), dtype=TEXT)


def read_hdf5(path: Path) -> StudyTable:
    """Return a table.

    Raises:
        ResultError: It cannot be read, or is not a table of a study.
    """
    try:
        with open_file(path, "r") as file:
            if _HEAD not in file.attrs:
                raise ResultError(f'"{path}" is not a table of a study')
            return _read(file, path)
    except ResultError:
        raise
    except OSError as error:
        raise ResultError(f'cannot read "{path}": {error}') from error
    except Exception as error:  # whatever damaged data make of HDF5
        raise ResultError(f'"{path}" is a damaged table: {error}') from error


def _read(file: Any, path: Path) -> StudyTable:
    facts: dict[str, Any] = json.loads(file.attrs[_HEAD])
    if facts.pop("format", None) != FORMAT:
        raise ResultError(f'"{path}" was written by another version of tissuec')
    head = msgspec.convert(facts, StudyHead)
    runs = _numbers(file["runs"], None, 1).astype(np.int64)
    if len(runs) and not 0 <= runs.min() <= runs.max() < head.planned:
        raise ValueError(f"there are other runs than {head.planned}")
    count = len(runs)
    texts = {name: _texts(file[name], count) for name in _TEXTS}
    texts["doubts"] = _texts(file["doubts"], count) if "doubts" in file else ("",) * count
    singles = [one for one in head.measures if one.every is None]
    curves = [one for one in head.measures if one.every is not None]
    return StudyTable(
        head=head,
        runs=runs,
        error=_numbers(file["error"], count, 1),
        end=_numbers(file["end"], count, 1) if "end" in file else np.full(count, np.nan),
        factors=tuple(
            _column(file["factors"], f.name, count, is_text=f.is_text) for f in head.factors
        ),
        measures=tuple(_column(file["measures"], m.name, count) for m in singles),
        curves=tuple(_curve(file["curves"], one.name, count) for one in curves),
        **texts,
    )


def _column(group: Any, name: str, count: int, *, is_text: bool = False) -> Column:
    stored = group[name.replace("/", "∕")]
    values = _texts(stored, count) if is_text else _numbers(stored, count, 1)
    return Column(name, str(stored.attrs["unit"]), values)


def _curve(group: Any, name: str, count: int) -> MeasureCurve:
    stored = group[name.replace("/", "∕")]
    unit, every = str(stored.attrs["unit"]), float(stored.attrs["every"])
    return MeasureCurve(name, unit, every, _numbers(stored, count, 2))


def _numbers(stored: Any, count: int | None, dimensions: int) -> Floats:
    """Return numbers in their unit, of so many rows, if it is known, and dimensions."""
    values: NDArray[Any] = stored[()]
    fits = count is None or len(values) == count
    if not (fits and values.ndim == dimensions and values.dtype.kind in "iuf"):
        raise ValueError(f"{stored.name} is not as it was written")
    return values.astype(float)


def _texts(stored: Any, count: int) -> tuple[str, ...]:
    values = tuple(stored.asstr()[()].tolist())
    if len(values) != count or not all(isinstance(text, str) for text in values):
        raise ValueError(f"{stored.name} is not as it was written")
    return values


RUN, SAMPLE = "run", "time of"


def to_pandas(table: StudyTable) -> "pandas.DataFrame":
    """Return a table; see `view.study_table.StudyTable.to_pandas`."""
    columns: dict[str, Any] = {column.title: column.values for column in table.columns}
    columns |= {"outcome": table.outcome, "reason": table.reason, "promise": table.promise}
    columns |= {"doubts": table.doubts, "end [s]": table.end}
    index = package("pandas", "to_pandas").Index(table.runs, name=RUN)
    frame = package("pandas", "to_pandas").DataFrame(columns | {"error": table.error}, index)
    frame.attrs.update(_about(table))
    return frame


def to_xarray(table: StudyTable) -> "xarray.Dataset":
    """Return a dataset; see `view.study_table.StudyTable.to_xarray`."""
    xarray = package("xarray", "to_xarray")
    levels = [list(dict.fromkeys(_listed(factor.values))) for factor in table.factors]
    shape = tuple(map(len, levels))
    is_grid = table.head.design == "grid" and table.is_complete and np.prod(shape) == len(table)
    axes, shape = (
        ([factor.name for factor in table.factors], shape)
        if is_grid
        else ([RUN], (len(table),))
    )
    coordinates: dict[str, Any] = {}
    for factor, level in zip(table.factors, levels, strict=True):
        values = level if is_grid else _listed(factor.values)
        axis = factor.name if is_grid else RUN
        coordinates[factor.name] = (axis, np.array(values), {"units": factor.unit})
    if not is_grid:
        coordinates[RUN] = table.runs
    data: dict[str, Any] = {}
    for column in table.measures:
        data[column.name] = (axes, column.numbers.reshape(shape), {"units": column.unit})
    for curve in table.curves:
        along = f"{SAMPLE} {curve.name}"
        coordinates[along] = (along, curve.times, {"units": "s"})
        values = curve.values.reshape((*shape, len(curve.times)))
        data[curve.name] = ([*axes, along], values, {"units": curve.unit})
    for name in ("outcome", "reason", "promise", "error", "doubts"):
        data[name] = (axes, np.array(getattr(table, name)).reshape(shape))
    data["end of run"] = (axes, table.end.reshape(shape), {"units": "s"})
    return xarray.Dataset(data, coordinates, _about(table))


def _listed(values: Floats | tuple[str, ...]) -> list[Any]:
    return list(values) if isinstance(values, tuple) else values.tolist()


def _about(table: StudyTable) -> dict[str, Any]:
    head = table.head
    return {"study": head.name, "scene": head.scene, "design": head.design}
