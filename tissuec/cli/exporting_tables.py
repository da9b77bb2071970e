"""What ``tissuec export`` writes of the table of a study."""

import sys
from pathlib import Path
from typing import Any

import click

from tissuec.cli.common import Settings, keep_input
from tissuec.core.errors import TissueError
from tissuec.core.files import write_file
from tissuec.core.report import Part, Report

HDF5 = "h5"
TABLES = ("csv", HDF5)


def export_table(
    settings: Settings, path: Path, names: tuple[str, ...], kind: str, output: Path | None
) -> Report:
    """Write a table, or some of its columns.

    Args:
        settings: Of the program.
        path: The table.
        names: Of measures and curves; if there are none, the whole table is written.
        kind: "csv" or "h5".
        output: The file; None for stdout.

    Raises:
        UsageError: The format does not hold what is asked for.
        TissueError: The table cannot be read, a column is none of it, or nothing is written.
    """
    from tissuec.studies.table_files import read_table

    if kind not in TABLES:
        raise click.UsageError(
            f'"{path}" is the table of a study, which has no frames; write it as .csv or .h5. '
            "Netcdf is written from Python: tissuec.read_table(…).to_xarray().to_netcdf(…)"
        )
    if kind == HDF5 and (names or output is None):
        wrong = "contains whole tables, no single columns; write these as CSV"
        raise click.UsageError(f"HDF5 {wrong if names else 'needs a file: -o table.h5'}")
    if output is not None:
        keep_input(output, path)
    table = read_table(path)
    if output is None and settings.json:
        return Report((), _plain(table, names), is_table=True)
    _write(table, names, kind, output)
    parts: list[Part] = [] if output is None else [f"wrote {output}"]
    return Report(parts, {"file": str(output), "runs": len(table)}, level="remark")


def _plain(table: Any, names: tuple[str, ...]) -> dict[str, Any]:
    """Return columns by their heads."""
    from tissuec.studies.table_export import export

    found = export(table, names or [one.name for one in (*table.measures, *table.curves)])
    return dict(zip(found.heads, zip(*found.rows, strict=True), strict=True))


def _write(table: Any, names: tuple[str, ...], kind: str, output: Path | None) -> None:
    """Write a table to a file or stdout."""
    if kind == HDF5:
        from tissuec.studies.table_hdf5 import write_hdf5

        assert output is not None
        write_hdf5(table, output)
        return
    text = _csv(table, names)
    if output is None:
        sys.stdout.write(text)
        return
    try:
        write_file(output, text)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise TissueError(f'cannot write "{output}": {reason}') from error


def _csv(table: Any, names: tuple[str, ...]) -> str:
    """Return the whole table as it is read again, or single columns as a plain table."""
    from tissuec.studies.table import rows_of
    from tissuec.studies.table_text import as_csv

    if not names:
        return as_csv(table.head, rows_of(table))
    from io import StringIO

    from tissuec.results.export import write_csv
    from tissuec.studies.table_export import export

    found, stream = export(table.shown, names), StringIO(newline="")
    write_csv([found.heads, *found.rows], stream)
    return stream.getvalue()
