"""``tissuec fmt``: Format scenes."""

import sys
from difflib import unified_diff
from pathlib import Path

import click

from tissuec.cli.common import Command, Settings
from tissuec.core.errors import CompileError, Diagnostic, as_dict
from tissuec.core.files import write_file
from tissuec.core.report import DONE, FAILED, WRONG_TEXT, Report, Verbatim

STDIN = "-"


@click.command(cls=Command)
@click.argument(
    "files", nargs=-1, required=True, type=click.Path(path_type=Path, allow_dash=True)
)
@click.option(
    "--check",
    "only_check",
    is_flag=True,
    help="Do not change files; exit with 1 if a file is not formatted.",
)
@click.option(
    "--diff", "show_diff", is_flag=True, help="Print the changes without applying them."
)
def command(
    settings: Settings, files: tuple[Path, ...], only_check: bool, show_diff: bool
) -> Report:
    """Format FILES in place; comments are kept.

    Measures in outputs, studies and learning are written as in conditions: "force(A)" in place
    of "force of A".

    "-" formats stdin to stdout.
    """
    changed: list[str] = []
    found: list[Diagnostic] = []
    printed = ""
    for path in files:
        try:
            old, new = _formatted(path)
        except CompileError as error:
            found += error.diagnostics
            continue
        if str(path) == STDIN and not (only_check or show_diff):
            printed += new
        elif old != new:
            changed.append(str(path))
            if show_diff:
                printed += _difference(path, old, new)
            elif not only_check:
                write_file(path, new)
            if not show_diff:
                settings.say(f"{'would format' if only_check else 'formatted'} {path}")
    document = {
        "changed": changed,
        "diagnostics": [*map(as_dict, found)],
        "printed": printed,
    }
    code = WRONG_TEXT if found else FAILED if only_check and changed else DONE
    return Report([Verbatim(printed)], document, code, found)


def _difference(path: Path, old: str, new: str) -> str:
    names = (str(path), f"{path} (formatted)")
    return "".join(unified_diff(old.splitlines(True), new.splitlines(True), *names))


def _formatted(path: Path) -> tuple[str, str]:
    from tissuec.lang.characters import normalise
    from tissuec.lang.printer import format_source
    from tissuec.scene.program.imports import read_source
    from tissuec.scene.reading.spellings import respelled

    source = (
        normalise(sys.stdin.buffer.read(), "stdin") if str(path) == STDIN else read_source(path)
    )
    written = source.text if str(path) == STDIN else path.read_bytes().decode("utf-8")
    return written, format_source(respelled(source))
