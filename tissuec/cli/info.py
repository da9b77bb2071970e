"""``tissuec info``: Summarise result files."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, cast

import click

from tissuec.cli.common import Command, Reports, Settings
from tissuec.core.report import Fact, FactSection, Part, Report


@click.command(cls=Command)
@click.argument("results", nargs=-1, required=True, type=click.Path(path_type=Path))
def command(settings: Settings, results: tuple[Path, ...]) -> Reports:
    """Summarise RESULTS: their contents, how they were made and how they ended.

    RESULTS are result files, or tables of studies.
    """
    documents = map(_summary, results)
    each = (Report([*_facts(document)], document) for document in documents)
    return Reports(each, len(results) > 1)


def _summary(path: Path) -> dict[str, Any]:
    """Return the summary of a result, or of the table of a study."""
    from tissuec.studies.table_files import is_table

    if is_table(path):
        from tissuec.studies.report import summary as table_summary
        from tissuec.studies.table_files import read_table

        return table_summary(read_table(path), path)
    from tissuec.results.info import summary
    from tissuec.results.trajectory import Trajectory

    with Trajectory.open(path) as trajectory:
        return summary(trajectory)


def _facts(document: dict[str, Any]) -> Iterator[Part]:
    for key, value in document.items():
        if isinstance(value, dict) and value:
            inner = cast("dict[str, Any]", value)
            yield FactSection(f"{key}:", [*_facts(inner)], apart=False)
        elif isinstance(value, list | tuple | dict):
            items = cast("Iterable[object]", value)
            yield Fact(key, ", ".join(map(str, items)) or "none")
        else:
            yield Fact(key, str(value))
