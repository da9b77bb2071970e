"""Tables of studies for interactive use: analyses, plots and files as methods."""

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tissuec.studies import table as studies

if TYPE_CHECKING:
    import pandas  # pyright: ignore[reportMissingImports, reportMissingTypeStubs]
    import xarray  # pyright: ignore[reportMissingImports]
    from matplotlib.figure import Figure

    from tissuec.studies.analysis.convergence import ObservedOrders
    from tissuec.studies.analysis.quantiles import Quantiles
    from tissuec.studies.analysis.sensitivity import Effects, SobolIndices


class StudyTable(studies.StudyTable, frozen=True, eq=False):
    __doc__ = studies.StudyTable.__doc__

    def sobol_indices(self, measure: str) -> "SobolIndices":
        """Return which part of the variance of a measure comes from which factor.

        See ``studies.analysis.sensitivity``.

        Raises:
            ValueError: The design is not "sobol indices", or too few runs have a value.
        """
        from tissuec.studies.analysis.sensitivity import sobol_indices

        return sobol_indices(self, measure)

    def orders(self, measure: str, along: str | None = None) -> "ObservedOrders":
        """Return how fast a measure converges while a factor is refined.

        See ``studies.analysis.convergence``.

        Args:
            measure: Name of the measure.
            along: Name of the refined factor, if it is not clear.

        Raises:
            ValueError: No three values of a factor can be compared.
        """
        from tissuec.studies.analysis.convergence import orders

        return orders(self, measure, along)

    def quantiles(self, measure: str, *parts: float) -> "Quantiles":
        """Return quantiles of a measure over the runs of a random design.

        See ``studies.analysis.quantiles``.

        Args:
            measure: Name of the measure.
            parts: Of the runs below each, between 0 and 1; by default from 5 % to 95 %.

        Raises:
            ValueError: The runs are no sample of a distribution, or none has a value.
        """
        from tissuec.studies.analysis.quantiles import PARTS, quantiles

        return quantiles(self, measure, parts or PARTS)

    def effects(self, measure: str) -> "Effects":
        """Return the value as written, and the range of a measure over each factor.

        See ``studies.analysis.sensitivity``.

        Raises:
            ValueError: The design is not "one at a time", or the scene as written has no value.
        """
        from tissuec.studies.analysis.sensitivity import effects

        return effects(self, measure)

    def plot(self, kind: str | None = None, **options: Any) -> "Figure":
        """Return a figure, as ``tissuec plot`` draws it; see ``view.plots.draw``.

        Args:
            kind: Such as "response" or "heat-map"; by default what suits the study.
            options: Of the kind, such as ``measure="pull"``, and ``size`` or ``title``.

        Raises:
            TissueError: It cannot be drawn, or matplotlib is not installed.
            WrongOption: An option is none of the kind's.
        """
        from tissuec.view.plots import draw

        return draw(kind, self, **options)

    def to_csv(self, path: "str | PathLike[str]") -> None:
        """Write the table as text.

        Raises:
            ResultError: It cannot be written.
        """
        from tissuec.studies.table_text import write_csv

        write_csv(self, Path(path))

    def to_hdf5(self, path: "str | PathLike[str]") -> None:
        """Write the table as HDF5.

        Raises:
            ResultError: It cannot be written.
        """
        from tissuec.studies.table_hdf5 import write_hdf5

        write_hdf5(self, Path(path))

    def to_pandas(self) -> "pandas.DataFrame":
        """Return the table without its curves; rows are named by the numbers of their runs.

        Raises:
            ImportError: pandas is not installed.
        """
        from tissuec.studies.table_hdf5 import to_pandas

        return to_pandas(self)

    def to_xarray(self) -> "xarray.Dataset":
        """Return the table along "run", or along its factors if it is a complete grid.

        Raises:
            ImportError: xarray is not installed.
        """
        from tissuec.studies.table_hdf5 import to_xarray

        return to_xarray(self)


def with_methods(table: studies.StudyTable) -> StudyTable:
    """Return a table that has its analyses, plots and files as methods."""
    return StudyTable(*(getattr(table, name) for name in table.__struct_fields__))


def read_table(path: "str | PathLike[str]") -> StudyTable:
    """Return the table of a study, also of one that is not finished.

    Args:
        path: A file in CSV, or in HDF5 if its name ends with ".h5" or ".hdf5".

    Raises:
        ResultError: It cannot be read, or is not a table of a study.
    """
    from tissuec.studies import table_files

    return with_methods(table_files.read_table(Path(path)))
