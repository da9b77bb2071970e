"""The command line: one file per command; only here anything is printed or exits."""

import gc
import os
import re
import signal
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import click

from tissuec.cli.common import CommandGroup, Settings, echo, print_json
from tissuec.core.blas import hold_to_one_thread
from tissuec.core.data import printable
from tissuec.core.errors import SimulationError, TissueError
from tissuec.core.hints import alternatives
from tissuec.core.report import DONE, INTERRUPTED, STOPPED, WRONG_TEXT
from tissuec.core.signals import SIGNALLED, Terminated, end_at_once, ending, exit_code
from tissuec.core.version import __version__

hold_to_one_thread()  # before NumPy is loaded, which starts threads of BLAS

#: How many more objects there are, before cycles among them are searched for: texts become
#: trees of many objects, few of which ever are garbage.
MANY_OBJECTS = 200_000
USUAL_THRESHOLDS = gc.get_threshold()  # of Python itself

#: The commands that ``--help`` lists first; all others follow by name.
FIRST = ("run", "check", "fmt", "explain")
#: Commands that programs call.
HIDDEN = ("companion",)
#: First line of the file of a command: its name and what ``--help`` says of it.
OPENING = re.compile(r'"""``tissuec (\w+)``: (.+)"""\n')


def summaries() -> dict[str, str]:
    """Return the help line of each command, from its file without importing it."""
    files = sorted(Path(__file__).parent.glob("*.py"))
    found = {path.stem: text for path in files if (text := summary(path.stem))}
    first = {name: found.pop(name) for name in FIRST}
    return first | found


def summary(name: str) -> str | None:
    """Return the help line of a command, None if there is no such command."""
    path = Path(__file__).parent / f"{name}.py"
    if name in HIDDEN or not name.isidentifier() or not path.is_file():
        return None
    with path.open(encoding="utf-8") as file:
        opening = OPENING.fullmatch(file.readline())
    return opening[2] if opening else None


class LazyGroup(CommandGroup):
    """A group that imports a command only when it is called, to start quickly."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the commands."""
        return list(summaries())

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command, None if there is no such command."""
        if cmd_name not in HIDDEN and summary(cmd_name) is None:
            return None
        return import_module(f"tissuec.cli.{cmd_name}").command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(summaries().items()))

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find a command; for an unknown one, suggest the nearest.

        Args:
            args: The words of the command line.

        Raises:
            UsageError: There is no such command.
        """
        known = args and (args[0].startswith("-") or self.get_command(ctx, args[0]))
        if args and not known:
            hint = alternatives(args[0], self.list_commands(ctx), what="commands")
            if args[0].endswith(".tis"):
                hint = f'did you mean "tissuec run {args[0]}"?'
            raise click.UsageError(
                f'there is no command "{args[0]}"' + (f"; {hint}" if hint else "")
            )
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; it succeeds if the reader of stdout closes it early, like ``head``."""
        try:
            return super().invoke(ctx)
        except BrokenPipeError:
            sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  # open until the exit
            return DONE


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="tissuec")
def group(settings: Settings) -> None:
    """tissuec turns words about tissue into physics, and physics into motion.

    \b
    tissuec library                    what there is to start from
    tissuec library copy sterilisation
    tissuec run sterilisation.tis      writes sterilisation.vtkhdf
    """


def main() -> None:
    """Run the command line; exit codes are those of design: 0, 1, 2, 3 or 130."""
    gc.set_threshold(MANY_OBJECTS)
    code = run_guarded(group)
    # Everything is written and reported; Ctrl-C would only print a traceback of the ending.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    gc.freeze()  # the end of the process frees what is left at once
    end_at_once(code)
    sys.exit(code)


DEBUG = "TISSUEC_DEBUG"  # environment variable: show tracebacks


def run_guarded(command: click.Command) -> int:
    """Run a command and return its exit code; with ``--json`` an error is a document too."""
    try:
        with ending():
            return int(command(standalone_mode=False) or DONE)
    except click.exceptions.Exit as error:
        return error.exit_code
    except (Exception, KeyboardInterrupt) as error:
        code, message = _judged(error)
        if "--json" in sys.argv:  # a command line that is wrong was not read to its end
            print_json({"ok": False, "error": message})
        elif isinstance(error, click.ClickException):
            # Final in click 8.5; what it shows can be changed before it is shown only here.
            error.message = printable(error.message)  # pyright: ignore[reportAttributeAccessIssue]
            error.show()
        else:
            head = "" if code > SIGNALLED else "error: "
            echo(f"{head}{message}", err=True)
        return code


def _judged(error: BaseException) -> tuple[int, str]:
    """Return the exit code for an error, and its message."""
    match error:
        case click.ClickException():
            return WRONG_TEXT, error.format_message()
        case click.Abort(__cause__=Terminated() as cause):
            return exit_code(cause.signal), f"interrupted by {cause}"
        case click.Abort() | KeyboardInterrupt():
            return INTERRUPTED, "interrupted"
        case SimulationError():
            return STOPPED, str(error)
        case TissueError():
            return WRONG_TEXT, str(error)
        case MemoryError():
            return STOPPED, "there is not enough memory for this scene"
        case OSError() if "libllvmlite" in str(error):
            return STOPPED, "llvmlite cannot be loaded: there is not enough memory for it"
        case OSError() if error.strerror:
            # What is read says so itself, as an error of the text or of the result.
            file = "the output" if error.filename is None else f'"{error.filename}"'
            return WRONG_TEXT, f"cannot write {file}: {error.strerror.lower()}"
        case _:
            pass
    if DEBUG in os.environ:
        raise error
    what = f"tissuec itself failed: {type(error).__name__}: {error}"
    return STOPPED, f"{what}\nplease report it with your scene and what {DEBUG}=1 shows"
