"""The command line: one file per command; only here anything is printed or exits."""

import gc
import os
import sys
from importlib import import_module

import click

from tissuec.cli.common import CommandGroup, Settings
from tissuec.cli.guard import run_guarded
from tissuec.core.errors import alternatives
from tissuec.core.version import __version__

# Matrices are small or sparse: threads of BLAS, which start with NumPy, cost more than they
# bring, and their sums would depend on how many processors there are.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

#: How many more objects there are, before cycles among them are searched for: texts become
#: trees of many objects, few of which ever are garbage.
MANY_OBJECTS = 50_000
USUAL_THRESHOLDS = gc.get_threshold()  # of Python itself

#: Command -> what ``--help`` says of it; its module, of the same name, is imported when used.
COMMANDS = {
    "run": "Simulate scenes and write their motion to HDF5.",
    "check": "Check scenes for mistakes without simulating.",
    "fmt": "Format scenes.",
    "explain": "Show the origin of every number of a scene, or explain a code.",
    "modes": "Print the natural frequencies, damping and modes of a scene.",
    "words": "List the words of a vocabulary and their values.",
    "validate": "Compare a run with SciPy's solvers.",
    "lab": "Test tissues in a virtual laboratory and compare with evidence.",
    "learn": "Fit parameters or words of a scene to measured data.",
    "study": "Run a scene many times: ranges, lists, samples; one table.",
    "compare": "Show the differences between two runs or scenes.",
    "bench": "Measure computing time against error, also of other solvers.",
    "plot": "Plot results, vocabularies and benchmarks.",
    "report": "Write a report page of a run: motion, curves and the origin of every number.",
    "info": "Summarise result files.",
    "view": "Play results in a browser page, or draw them as pictures.",
    "export": "Write logs as CSV, or frames as VTU or OBJ.",
    "import": "Show the contents of a mesh file, as a scene to start from.",
    "library": "List the shipped library, or copy a part of it.",
    "lsp": "Start the language server for editors.",
    "completion": "Print a completion script for your shell.",
}
#: Commands that programs call.
HIDDEN = ("companion",)


class LazyGroup(CommandGroup):
    """A group that imports a command only when it is called, to start quickly."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the commands."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command, None if there is no such command."""
        if cmd_name not in (*COMMANDS, *HIDDEN):
            return None
        return import_module(f"tissuec.cli.{cmd_name}").command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find a command; for an unknown one, suggest the nearest.

        Args:
            ctx: Context of click.
            args: The words of the command line.

        Raises:
            UsageError: There is no such command.
        """
        if args and args[0] not in (*COMMANDS, *HIDDEN) and not args[0].startswith("-"):
            hint = alternatives(args[0], COMMANDS, what="commands")
            if args[0].endswith(".tis"):
                hint = f'did you mean "tissuec run {args[0]}"?'
            raise click.UsageError(
                f'there is no command "{args[0]}"' + (f"; {hint}" if hint else "")
            )
        return super().resolve_command(ctx, args)


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
    gc.freeze()  # the end of the process frees what is left at once
    sys.exit(code)
