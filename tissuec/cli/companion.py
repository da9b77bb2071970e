"""``tissuec companion``: the process that a run starts beside itself; not for people."""

from pathlib import Path

import click

from tissuec.cli.common import DONE, Command, Settings


@click.command(cls=Command, hidden=True)
@click.argument("folder", type=click.Path(path_type=Path))
def command(settings: Settings, folder: Path) -> int:
    """Step the companion run that FOLDER describes."""
    import signal

    from tissuec.pipeline import step_companion

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the run, which ends this
    step_companion(folder)
    return DONE
