"""Tables of studies for pandas and xarray, where these are installed."""

from typing import TYPE_CHECKING, Any

import numpy as np

from tissuec.model.network import Floats
from tissuec.results.conversion import package
from tissuec.studies.table import StudyTable

if TYPE_CHECKING:
    import pandas  # pyright: ignore[reportMissingImports, reportMissingTypeStubs]
    import xarray  # pyright: ignore[reportMissingImports]

RUN, SAMPLE = "run", "time of"


def to_pandas(table: StudyTable) -> "pandas.DataFrame":
    """Return a table; see `view.study_table.StudyTable.to_pandas`."""
    columns: dict[str, Any] = {column.title: column.values for column in table.columns}
    columns |= {"outcome": table.outcome, "reason": table.reason, "promise": table.promise}
    columns |= {"doubts": table.doubts}
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
    return xarray.Dataset(data, coordinates, _about(table))


def _listed(values: Floats | tuple[str, ...]) -> list[Any]:
    return list(values) if isinstance(values, tuple) else values.tolist()


def _about(table: StudyTable) -> dict[str, Any]:
    head = table.head
    return {"study": head.name, "scene": head.scene, "design": head.design}
