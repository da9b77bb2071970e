"""``tissuec lsp``"""

from pathlib import Path

import click

from tissuec.cli.common import DONE, Command, Settings, library_option
from tissuec.core.errors import TissueError


@click.command(cls=Command)
@library_option("what texts use")
@click.option("--stdio", is_flag=True, help="Speak over stdin and stdout, as it always does.")
def command(settings: Settings, libraries: tuple[Path, ...], stdio: bool) -> int:
    """Answer what an editor asks about texts: a language server.

    Editors start it by themselves; the page "Writing scenes" of the manual says how. It reads
    requests from stdin and answers on stdout.
    """
    try:
        import pygls.lsp.server  # noqa: F401  (told here, before anything else is loaded)
    except ImportError:
        raise TissueError(
            'the language server needs pygls: pip install "tissuec[lsp]"'
        ) from None
    from tissuec.lsp.server import make_server

    make_server(libraries).start_io()
    return DONE
