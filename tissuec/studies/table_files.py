"""The files of tables: CSV, or HDF5 by the ending of the name."""

from pathlib import Path

from tissuec.studies.table import StudyTable


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
