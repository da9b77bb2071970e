"""``tissuec info``: Summarise result files."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any, cast

import click

from tissuec.cli.common import DONE, Command, Settings, echo, print_json


@click.command(cls=Command)
@click.argument("results", nargs=-1, required=True, type=click.Path(path_type=Path))
def command(settings: Settings, results: tuple[Path, ...]) -> int:
    """Summarise RESULTS: their contents, how they were made and how they ended.

    RESULTS are result files, or tables of studies.
    """
    documents = [_summary(path) for path in results]
    if settings.json:
        print_json(documents[0] if len(documents) == 1 else documents)
        return DONE
    for document in documents:
        for line in _lines(document, ""):
            echo(line)
    return DONE


def _summary(path: Path) -> dict[str, Any]:
    """Return the summary of a result, or of the table of a study."""
    from tissuec.studies.table_files import is_table

    if is_table(path):
        from tissuec.studies import summary as of_tables
        from tissuec.studies.table_files import read_table

        return of_tables.summary(read_table(path), path)
    from tissuec.results.info import summary
    from tissuec.results.trajectory import Trajectory

    with Trajectory.open(path) as trajectory:
        return summary(trajectory)


def _lines(document: dict[str, Any], indent: str) -> list[str]:
    lines: list[str] = []
    for key, value in document.items():
        if isinstance(value, dict):
            inner = cast("dict[str, Any]", value)
            lines.append(f"{indent}{key}:" if inner else f"{indent}{key}: none")
            lines += _lines(inner, indent + "  ")
        else:
            text = value
            if isinstance(value, list | tuple):
                items = cast("Iterable[object]", value)
                text = ", ".join(map(str, items)) or "none"
            lines.append(f"{indent}{key}: {text}")
    return lines
