"""Code that commands share: global flags, output and exit codes."""

import os
import re
import shlex
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from itertools import islice, takewhile
from pathlib import Path
from shutil import get_terminal_size
from typing import Any, TextIO, TypeVar

import click
from msgspec import Struct

from tissuec.cli.completing import params
from tissuec.core.data import as_data
from tissuec.core.errors import CompileError, Diagnostic, TissueError, as_dict, counted, render
from tissuec.core.printable import printable

DONE, FAILED, WRONG_TEXT, STOPPED, INTERRUPTED = 0, 1, 2, 3, 130
PAGES = (".html", ".htm")  # endings of pages
FILES = (".tis", ".vtkhdf", ".csv", ".h5")  # endings of what commands are given
F = TypeVar("F", bound=Callable[..., Any])

#: The global flags: name -> (spellings, help).
FLAGS: dict[str, tuple[tuple[str, ...], str]] = {
    "json": (("--json",), "Print one JSON document on stdout."),
    "quiet": (("-q", "--quiet"), "Print only errors on stderr."),
    "verbose": (("-v", "--verbose"), "Print more details on stderr."),
    "no_color": (
        ("--no-color",),
        "Disable colours (as does the environment variable NO_COLOR).",
    ),
}


class Settings(Struct, frozen=True):
    """The global flags, before or after the name of a command, and what they depend on.

    Attributes:
        strict: Whether warnings are errors, for commands that compile a scene.
    """

    json: bool = False
    quiet: bool = False
    verbose: bool = False
    no_color: bool = False
    strict: bool = False

    def merged(self, flags: dict[str, bool], *, strict: bool) -> "Settings":
        """Return these settings with the flags that are set in addition."""
        both = {name: getattr(self, name) or flags[name] for name in FLAGS}
        return Settings(**both, strict=strict)

    @property
    def color(self) -> bool:
        """Return whether stderr shows colours."""
        return not self.no_color and "NO_COLOR" not in os.environ and sys.stderr.isatty()

    @property
    def shows_progress(self) -> bool:
        """Return whether lines of progress are wanted, where there is a terminal."""
        return not (self.quiet or self.json)

    def say(self, text: str = "") -> None:
        """Print to stderr, unless output is suppressed."""
        if not self.quiet:
            echo(_wrapped(text, line_width(sys.stderr)), err=True)


def _wrapped(text: str, width: int) -> str:
    """Return text whose lines break between words at a width."""
    if len(text) <= width:
        return text
    from textwrap import wrap  # which few commands need

    return "\n".join(
        part
        for line in text.split("\n")
        for part in wrap(
            line, width, break_long_words=False, break_on_hyphens=False,
            subsequent_indent=(len(line) - len(line.lstrip()) + 2) * " ",
            replace_whitespace=False,
        ) or [""]
    )  # fmt: skip


def line_width(stream: TextIO) -> int:
    """Return how many characters a line may have: those of a terminal, any number in a file."""
    return get_terminal_size().columns if stream.isatty() else sys.maxsize


def echo(text: str, *, err: bool = False) -> None:
    """Print text that may hold names and messages from anywhere; on stderr for ``err``."""
    click.echo(printable(text), err=err)


def flag_options() -> list[click.Parameter]:
    """Return the global flags as options."""
    return [
        click.Option(spellings, is_flag=True, help=text) for spellings, text in FLAGS.values()
    ]


class Command(click.Command):
    """A command that takes the global flags too and hands them on as ``settings``, also to
    commands below it.

    Where it leaves a CompileError to its caller, the findings are shown as the flags demand.
    """

    def __init__(self, *args: Any, **keywords: Any):
        super().__init__(*args, **keywords)
        self.params += flag_options()

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse the command line.

        ``--set lift = 8 mm``, which the shell splits into four words, and ``--lift 8mm``, which
        is not an option, are reported with the correct form.

        Raises:
            UsageError: An option is written in one of these forms, or has two values.
        """
        written = tuple(args)  # which click uses up
        self._refuse_repeated(ctx, written)
        for place, word in enumerate(written):
            parted = _value_at(written, place + 1) if word == "--set" else []
            if any(part == "is" or part.startswith("=") for part in parted[1:]):
                raise click.UsageError(
                    f"put a value with blanks in quotes: --set {_quoted(' '.join(parted))}"
                )
        try:
            return super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            is_long = error.option_name.startswith("--")
            if not is_long or all(one.name != "overrides" for one in self.params):
                raise
            name, value = _unknown(written, error.option_name)
            assignment = f"{name.replace('-', ' ')} = {value}"
            meant = f" (did you mean {' or '.join(error.possibilities or ())}?)"
            raise click.UsageError(
                f"there is no option --{name}{meant if error.possibilities else ''}; to set an "
                f"entry or a param of the scene: --set {_quoted(assignment)}"
            ) from error

    def _refuse_repeated(self, ctx: click.Context, written: tuple[str, ...]) -> None:
        """Refuse an option with two values, of which click would pass over the first.

        Raises:
            UsageError: There is one.
        """
        twice: click.Option | None = None
        with suppress(click.UsageError):  # which is reported when the options are used
            parsed: list[click.Parameter] = self.make_parser(ctx).parse_args([*written])[2]
            single = [
                one for one in parsed
                if isinstance(one, click.Option)
                and not (one.multiple or one.is_flag or one.count)
            ]  # fmt: skip
            twice = next((one for k, one in enumerate(single) if one in single[:k]), None)
        if twice is not None:
            raise click.UsageError(f"{max(twice.opts, key=len)} is given twice: give it once")

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command with its settings; show findings of a text as the flags demand."""
        flags = {name: ctx.params.pop(name) for name in FLAGS}
        strict = ctx.params.get("strict", False)
        settings = (ctx.find_object(Settings) or Settings()).merged(flags, strict=strict)
        ctx.obj = ctx.params["settings"] = settings
        try:
            return super().invoke(ctx)
        except CompileError as error:
            tell_mistakes(error, settings)
            return WRONG_TEXT


def _unknown(written: Sequence[str], option: str) -> tuple[str, str]:
    """Return the name of an option that there is not, and what was written as its value."""
    for place, word in enumerate(written):
        head, _, value = word.partition("=")
        if head == option:
            return head[2:], value or " ".join(_value_at(written, place + 1)) or "…"
    return option[2:], "…"


def _value_at(written: Sequence[str], start: int) -> list[str]:
    """Return the words of a value: up to an option or the name of a file; "-1" is no option."""
    among = islice(written, start, None)
    value = takewhile(lambda word: re.match(r"-(?![\d.])", word) is None, among)
    return [word for word in value if Path(word).suffix not in FILES]


def _quoted(text: str) -> str:
    """Return a text as one word of a command line."""
    return shlex.quote(text) if set(text) & set('"$`\\!') else f'"{text}"'


class CommandGroup(Command, click.Group):
    """A group of commands that takes the global flags too."""


def library_option(wanted: str = "used files") -> Callable[[F], F]:
    """Return the option for further folders in which something is searched for."""
    return click.option(
        "--library",
        "libraries",
        multiple=True,
        metavar="DIR",
        type=click.Path(path_type=Path, exists=True, file_okay=False),
        help=f"Also search this folder for {wanted}.",
    )


def show_page(page: Path) -> None:
    """Show a page in the browser."""
    import webbrowser  # late: few runs show any

    webbrowser.open(page.resolve().as_uri())


def scene_options(function: F) -> F:
    """Add what every command that compiles a scene takes."""
    options = (
        click.option(
            "--set",
            "overrides",
            multiple=True,
            metavar="NAME=VALUE",
            shell_complete=params,
            help='Set a param to another value, such as "cut time=0.9 s", or an entry of a '
            'block, such as "hardness of fallopian tube is soft" or "tolerance=1e-6".',
        ),
        library_option(),
        click.option("--strict", is_flag=True, help="Treat warnings as errors."),
    )
    for option in reversed(options):  # the last one applied stands first in the help
        function = option(function)
    return function


def worker_options(function: F) -> F:
    """Add what says who does the work of a command that has much of it."""
    function = click.option(
        "--scheduler",
        metavar="ADDRESS",
        help="Use the workers of a dask scheduler, such as tcp://127.0.0.1:8786.",
    )(function)
    return click.option(
        "--workers",
        type=click.IntRange(min=1),
        help="Number of processes; by default one for each processor. 1 runs in this process.",
    )(function)


def print_json(document: Any) -> None:
    """Print the one JSON document of a command; NaN and infinity become null."""
    import json  # late: most commands print none

    echo(json.dumps(as_data(document), indent=2, ensure_ascii=False, allow_nan=False))


def report(diagnostics: Sequence[Diagnostic], settings: Settings) -> None:
    """Show diagnostics on stderr, as text; quietly, those that are errors."""
    shows_warnings = settings.strict or not settings.quiet
    for diagnostic in diagnostics:
        if diagnostic.severity == "error" or shows_warnings:
            click.echo(render(diagnostic, color=settings.color), err=True)


def tell_mistakes(error: CompileError, settings: Settings, **facts: Any) -> None:
    """Show why a text is wrong: on stderr, or with further facts as the JSON document.

    Args:
        error: The findings.
        settings: Global flags.
        facts: Further facts.
    """
    if settings.json:
        print_json({**facts, "ok": False, "diagnostics": as_json(error.diagnostics)})
    else:
        report(error.diagnostics, settings)


def as_json(diagnostics: Sequence[Diagnostic]) -> list[dict[str, Any]]:
    """Return diagnostics as plain data."""
    return [as_dict(diagnostic) for diagnostic in diagnostics]


def summary(errors: int, warnings: int) -> str:
    """Return "2 errors, 1 warning", or an empty string."""
    counts = ((errors, "error"), (warnings, "warning"))
    return ", ".join(counted(number, what) for number, what in counts if number)


def check_page_name(page: Path, instead: str = "") -> None:
    """Refuse to write a page under the name of something else, which might be lost.

    Args:
        page: File to be written.
        instead: What to write for other files.

    Raises:
        UsageError: The name does not end as those of pages do.
    """
    is_device = page.exists() and not page.is_file()
    if page.suffix.lower() not in PAGES and not is_device:
        raise click.UsageError(
            f'the name of a page must end in .html, unlike "{page}"{instead and f"; {instead}"}'
        )


def keep_input(output: Path, given: Path) -> None:
    """Refuse to overwrite an input file, by whatever name or link.

    Raises:
        TissueError: Output and input are the same file.
    """
    if os.path.exists(output) and os.path.exists(given) and os.path.samefile(output, given):
        raise TissueError(f'"{output}" is the input file; give the output another name')
