"""``tissuec lsp``: Start the language server for editors."""

from importlib import import_module
from pathlib import Path

import click

from tissuec.cli.common import Command, Settings, library_option
from tissuec.core.errors import TissueError
from tissuec.core.report import Report


@click.command(cls=Command)
@library_option("used files")
@click.option("--stdio", is_flag=True, help="Communicate over stdin and stdout (the default).")
@click.option(
    "--vsix",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Write the VS Code extension to this file instead.",
)
def command(
    settings: Settings, libraries: tuple[Path, ...], stdio: bool, vsix: Path | None
) -> Report | None:
    """Start the language server for editors.

    Editors start it automatically; see the page "Writing scenes" of the manual. It reads
    requests from stdin and answers on stdout.
    """
    if vsix is not None:
        return _write(vsix)
    try:
        import_module("pygls.lsp.server")  # reported here, before anything else is loaded
    except ImportError:
        raise TissueError(
            'the language server needs pygls: pip install "tissuec[lsp]"'
        ) from None
    from tissuec.lsp.server import make_server

    make_server(libraries).start_io()
    return None


def _write(target: Path) -> Report:
    """Write the extension, and say how it is installed."""
    from tissuec.lsp.vscode import write_vsix

    try:
        write_vsix(target)
    except OSError as error:
        place = Path(error.filename or target)
        what = "write" if place == target else "read"
        raise TissueError(f'cannot {what} "{place}": {error.strerror}') from None
    how = f"{target}: install it with code --install-extension {target}"
    return Report([how], {"file": str(target)}, level="remark")
