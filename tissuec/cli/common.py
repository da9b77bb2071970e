"""Code that commands share: global flags, output and exit codes."""

import os
import re
import shlex
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from functools import wraps
from itertools import islice, takewhile
from pathlib import Path
from shutil import get_terminal_size
from typing import TYPE_CHECKING, Any, TextIO, TypeVar

import click
from msgspec import Struct

from tissuec.cli.completing import params
from tissuec.core.data import as_data, printable
from tissuec.core.errors import CompileError, Diagnostic, TissueError, as_dict, render
from tissuec.core.report import DONE, WRONG_TEXT, Level, Part, Report, Verbatim, lines
from tissuec.core.signals import SIGNALLED

if TYPE_CHECKING:
    from tissuec.scene.request import Request

PAGES = (".html", ".htm")  # endings of pages
FILES = (".tis", ".vtkhdf", ".csv", ".h5")  # endings of what commands are given
#: Words that announce a failure, and how terminals show them.
_RAISED, _RED = re.compile(r"^( *)(FAILED|error|warning|doubtful)\b"), r"\1\033[1;31m\2\033[0m"
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
    """The global flags, before or after the name of a command, and their context.

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

    def warn(self, diagnostics: Sequence[Diagnostic]) -> list[dict[str, Any]]:
        """Show diagnostics, unless they become JSON; return them as plain data."""
        if not self.json:
            self._diagnose(diagnostics)
        return [*map(as_dict, diagnostics)]

    def show(self, *parts: Part, level: Level = "result") -> None:
        """Print parts of a report before it is complete, unless it becomes JSON."""
        if not self.json:
            self._print(parts, level)

    def publish(self, found: "Report | Reports") -> int:
        """Print reports as text or as one JSON document; return the exit code."""
        reports = Reports([found]) if isinstance(found, Report) else found
        codes: list[int] = [DONE]
        documents: list[Any] = []
        for report in reports.each:
            codes.append(report.code)
            if self.json:
                documents.append(report.as_json())
            else:
                self._diagnose(report.findings)
                self._print(report.parts, report.level)
            if report.code > SIGNALLED:
                break
        if self.json:
            print_json(documents if reports.is_list else documents[0])
        return max(codes)

    def _diagnose(self, diagnostics: Iterable[Diagnostic]) -> None:
        """Show diagnostics on stderr; quietly, those that are errors."""
        for diagnostic in diagnostics:
            if diagnostic.severity == "error" or self.strict or not self.quiet:
                click.echo(render(diagnostic, color=self.color), err=True)

    def _print(self, parts: Iterable[Part], level: Level) -> None:
        for part in parts:
            if isinstance(part, Verbatim):  # also characters that no terminal should get
                click.echo(part.text, nl=False)
                continue
            for line_level, line in lines([part], level, line_width(sys.stdout)):
                if line_level == "result":
                    echo(line)
                elif line_level == "failure":
                    shown = _wrapped(line, line_width(sys.stderr))
                    echo(_RAISED.sub(_RED, shown) if self.color else shown, err=True)
                else:
                    self.say(line)


class Reports(Struct, frozen=True):
    """Reports on several subjects, each printed when it is complete.

    Attributes:
        is_list: Whether the JSON document is a list; otherwise it is that of the only report.
    """

    each: Iterable[Report]
    is_list: bool = False


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

    It returns a report, several, or an exit code, and may raise a CompileError: what is found
    is shown as the flags demand.
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
        """Run the command with its settings; print its report as the flags demand."""
        flags = {name: ctx.params.pop(name) for name in FLAGS}
        strict = ctx.params.get("strict", False)
        settings = (ctx.find_object(Settings) or Settings()).merged(flags, strict=strict)
        ctx.obj = ctx.params["settings"] = settings
        try:
            found = super().invoke(ctx)
        except CompileError as error:
            scene = ctx.params.get("scene")
            facts = {} if scene is None else {"scene": str(scene)}
            found = Report((), facts, WRONG_TEXT, error.diagnostics)
        return settings.publish(found) if isinstance(found, Report | Reports) else found


def _unknown(written: Sequence[str], option: str) -> tuple[str, str]:
    """Return the name of an unknown option, and its written value."""
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


class SceneOptions(Struct, frozen=True):
    """Options of every command that compiles a scene; see ``scene_options``."""

    overrides: tuple[str, ...] = ()
    libraries: tuple[Path, ...] = ()
    strict: bool = False

    def request(self, path: Path) -> "Request":
        """Return the request for a scene.

        Raises:
            CompileError: The file cannot be read.
        """
        from tissuec.scene.request import Request

        return Request.file(
            path, overrides=self.overrides, libraries=self.libraries, strict=self.strict
        )


def scene_options(function: F) -> F:
    """Add the options of every command that compiles a scene, as ``given``."""

    @wraps(function)
    def with_options(
        *args: Any, overrides: tuple[str, ...], libraries: tuple[Path, ...], strict: bool,
        **others: Any,
    ) -> Any:  # fmt: skip
        given = SceneOptions(overrides, libraries, strict)
        return function(*args, given=given, **others)

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
    found: Any = with_options
    for option in reversed(options):  # the last one applied is the first in the help
        found = option(found)
    return found


def worker_options(function: F) -> F:
    """Add the options that select the workers of a command with many runs."""
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
