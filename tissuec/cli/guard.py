"""Errors become a message and an exit code, never a traceback."""

import os
import sys

import click

from tissuec.cli.common import echo, print_json
from tissuec.core.errors import SimulationError, TissueError
from tissuec.core.printable import printable
from tissuec.core.report import DONE, INTERRUPTED, STOPPED, WRONG_TEXT
from tissuec.engine.execution.signals import SIGNALLED, Terminated, ending, exit_code

DEBUG = "TISSUEC_DEBUG"  # environment variable: show tracebacks


def run_guarded(command: click.Command) -> int:
    """Run a command and return its exit code; with ``--json`` an error is a document too."""
    try:
        with ending():
            return int(command(standalone_mode=False) or DONE)
    except click.exceptions.Exit as error:
        return error.exit_code
    except BrokenPipeError:
        # The reader of stdout has seen enough, as with "| head".
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115  # open until the exit
        return DONE
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
