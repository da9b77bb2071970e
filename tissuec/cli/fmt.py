"""``tissuec fmt``"""

import sys
from difflib import unified_diff
from pathlib import Path

import click

from tissuec.cli.common import DONE, FAILED, WRONG_TEXT, Command, Settings, print_json, report
from tissuec.core.errors import CompileError


@click.command(cls=Command)
@click.argument(
    "files", nargs=-1, required=True, type=click.Path(path_type=Path, allow_dash=True)
)
@click.option(
    "--check",
    "only_check",
    is_flag=True,
    help="Change nothing; exit with 1 if a file is not laid out so.",
)
@click.option(
    "--diff", "show_diff", is_flag=True, help="Print what would change, and change nothing."
)
def command(
    settings: Settings, files: tuple[Path, ...], only_check: bool, show_diff: bool
) -> int:
    """Lay FILES out in the one canonical way, in place; comments stay.

    "-" is stdin to stdout.
    """
    changed: list[str] = []
    wrong = False
    for path in files:
        try:
            old, new = _formatted(path)
        except CompileError as error:
            report(error.diagnostics, settings)
            wrong = True
            continue
        if str(path) == "-" and not (only_check or show_diff):
            click.echo(new, nl=False)
        elif old != new:
            changed.append(str(path))
            if show_diff:
                names = (str(path), f"{path} (formatted)")
                click.echo(
                    "".join(unified_diff(old.splitlines(True), new.splitlines(True), *names)),
                    nl=False,
                )
            elif not only_check:
                _replace(path, new)
                settings.say(f"formatted {path}")
            else:
                settings.say(f"would format {path}")
    if settings.json:
        print_json({"changed": changed})
    if wrong:
        return WRONG_TEXT
    return FAILED if only_check and changed else DONE


def _formatted(path: Path) -> tuple[str, str]:
    from tissuec.lang.characters import normalise
    from tissuec.lang.printer import format_source
    from tissuec.scene.imports import read_source

    source = (
        normalise(sys.stdin.buffer.read(), "stdin") if str(path) == "-" else read_source(path)
    )
    written = source.text if str(path) == "-" else path.read_bytes().decode("utf-8")
    return written, format_source(source)


def _replace(path: Path, text: str) -> None:
    """Write the new text beside the file and put it in its place, so that nothing is lost."""
    beside = path.with_name(path.name + ".new")
    beside.write_text(text, encoding="utf-8", newline="\n")
    beside.chmod(path.stat().st_mode)
    beside.replace(path)
