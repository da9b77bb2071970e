"""Where results go: to stdout as Markdown or JSON, and into the pages of ``docs``."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from tissuec.cli.common import print_json
from tissuec.core.markdown import replace_places

DOCS = Path(__file__).resolve().parent.parent / "docs"

write_option = click.option("--write", is_flag=True, help="Also write the tables into docs.")
json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print one JSON document instead of tables."
)


def tell(text: str) -> None:
    """Say on stderr what is being done."""
    click.echo(text, err=True)


def publish(
    name: str,
    tables: Mapping[str, str],
    *,
    write: bool = False,
    page: str = "numerics.md",
    document: Any = None,
) -> None:
    """Print what was measured.

    Args:
        name: Of the benchmark, which marks its places in the page.
        tables: Markdown by the names of the places.
        write: Whether the places are filled, too.
        page: Of ``docs``.
        document: Plain data to print as JSON instead of tables.
    """
    if document is None:
        click.echo("\n\n".join(tables.values()))
    else:
        print_json(document)
    if write:
        path = DOCS / page
        text = path.read_text(encoding="utf-8")
        filled = replace_places(text, tables, mark=f"benchmarks.{name}")
        path.write_text(filled, encoding="utf-8")
