"""What the commands share: global flags, how they speak, and exit codes."""

import json
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import click

from tissuec.core.errors import CompileError, Diagnostic, SimulationError, TissueError

DONE, FAILED, WRONG_TEXT, STOPPED, INTERRUPTED = 0, 1, 2, 3, 130
DEBUG = "TISSUEC_DEBUG"  # environment variable: show tracebacks
F = TypeVar("F", bound=Callable[..., Any])


#: The global flags: name -> (spellings, help).
FLAGS: dict[str, tuple[tuple[str, ...], str]] = {
    "json": (("--json",), "One JSON document on stdout."),
    "quiet": (("-q", "--quiet"), "Say nothing on stderr but errors."),
    "verbose": (("-v", "--verbose"), "Say more on stderr."),
    "no_color": (("--no-color",), "No colours (also with NO_COLOR set)."),
}


@dataclass(frozen=True, slots=True)
class Settings:
    """The global flags, before or behind the name of a command."""

    json: bool = False
    quiet: bool = False
    verbose: bool = False
    no_color: bool = False

    def merged(self, flags: dict[str, bool]) -> "Settings":
        """Return these settings with the flags that are set in addition."""
        return Settings(**{name: getattr(self, name) or flags[name] for name in FLAGS})

    @property
    def color(self) -> bool:
        """Return whether stderr shows colours."""
        return not self.no_color and "NO_COLOR" not in os.environ and sys.stderr.isatty()

    def say(self, text: str = "") -> None:
        """Talk on stderr, unless told to be quiet."""
        if not self.quiet:
            click.echo(text, err=True)


def flag_options() -> list[click.Parameter]:
    """Return the global flags as options."""
    return [
        click.Option(spellings, is_flag=True, help=text) for spellings, text in FLAGS.values()
    ]


class Command(click.Command):
    """A command that takes the global flags too and hands them on as ``settings``."""

    def __init__(self, *args: Any, **keywords: Any):
        super().__init__(*args, **keywords)
        self.params += flag_options()

    def invoke(self, ctx: click.Context) -> Any:
        flags = {name: ctx.params.pop(name) for name in FLAGS}
        ctx.params["settings"] = (ctx.find_object(Settings) or Settings()).merged(flags)
        return super().invoke(ctx)


def scene_options(function: F) -> F:
    """Add what every command that compiles a scene takes."""
    function = click.option("--strict", is_flag=True, help="Treat warnings as errors.")(
        function
    )
    function = click.option(
        "--library", "libraries", multiple=True, type=click.Path(path_type=Path, exists=True, file_okay=False),
        help="Also search this folder for what scenes use.", metavar="DIR",
    )(function)  # fmt: skip
    return click.option(
        "--set",
        "overrides",
        multiple=True,
        metavar="NAME=VALUE",
        help='Give a param another value, such as "cut time=0.9 s".',
    )(function)


def print_json(document: Any) -> None:
    """Print the one JSON document of a command; NaN and infinity become null."""
    click.echo(json.dumps(_plain(document), indent=2, ensure_ascii=False, allow_nan=False))


def _plain(value: Any) -> Any:
    import math

    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value


def report(diagnostics: Sequence[Diagnostic], settings: Settings) -> None:
    """Show diagnostics on stderr, as text."""
    from tissuec.lang.render import render

    for diagnostic in diagnostics:
        if diagnostic.severity == "error" or not settings.quiet:
            click.echo(render(diagnostic, color=settings.color), err=True)


def as_json(diagnostics: Sequence[Diagnostic]) -> list[dict[str, Any]]:
    """Return diagnostics as plain data."""
    from tissuec.lang.render import as_dict

    return [as_dict(diagnostic) for diagnostic in diagnostics]


def summary(errors: int, warnings: int) -> str:
    """Return "2 errors, 1 warning", or an empty string."""
    parts = [
        f"{n} {word}{'s' if n > 1 else ''}"
        for n, word in ((errors, "error"), (warnings, "warning"))
        if n
    ]
    return ", ".join(parts)


def run_guarded(command: click.Command) -> int:
    """Run a command and return its exit code; errors become messages, never tracebacks."""
    try:
        return int(command(standalone_mode=False) or DONE)
    except click.exceptions.Exit as error:
        return error.exit_code
    except click.ClickException as error:
        error.show()
        return WRONG_TEXT
    except (click.Abort, KeyboardInterrupt):
        click.echo("interrupted", err=True)
        return INTERRUPTED
    except CompileError as error:
        report(error.diagnostics, Settings())
        return WRONG_TEXT
    except SimulationError as error:
        click.echo(f"error: {error}", err=True)
        return STOPPED
    except TissueError as error:
        click.echo(f"error: {error}", err=True)
        return WRONG_TEXT
    except MemoryError:
        click.echo("error: there is not enough memory for this scene", err=True)
        return STOPPED
    except BrokenPipeError:
        # The reader of stdout has seen enough, as with "| head".
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115  # stays open until the exit
        return DONE
    except Exception as error:
        if DEBUG in os.environ:
            raise
        what = f"{type(error).__name__}: {error}"
        click.echo(f"error: tissuec itself failed: {what}", err=True)
        click.echo(f"please report it with your scene and what {DEBUG}=1 shows", err=True)
        return STOPPED
