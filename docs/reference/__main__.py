"""``python -m docs.reference [--check] [FOLDER]`` fills the pages of ``docs/`` anew.

It also writes what highlights scenes in editors, in ``grammars/``.
"""

import sys
from pathlib import Path

import click

from docs.reference.pages import outdated, outdated_grammars


@click.command()
@click.argument(
    "folder", default="docs", type=click.Path(path_type=Path, exists=True, file_okay=False)
)
@click.option(
    "--check", is_flag=True, help="Change nothing; exit with 1 if a page is out of date."
)
def main(folder: Path, check: bool) -> None:
    """Fill the generated parts of the pages in FOLDER anew, and the grammars of editors."""
    fresh = outdated(folder) | outdated_grammars()
    for page, text in fresh.items():
        if not check:
            page.parent.mkdir(parents=True, exist_ok=True)
            page.write_text(text, encoding="utf-8", newline="\n")
        click.echo(f"{'out of date' if check else 'rewrote'}: {page}")
    sys.exit(1 if check and fresh else 0)


main()
