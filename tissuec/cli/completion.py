"""``tissuec completion``: Print a completion script for your shell."""

import click
from click.shell_completion import get_completion_class

from tissuec.cli.common import Command, Settings
from tissuec.core.report import Report, Verbatim

SHELLS = ("bash", "zsh", "fish")


@click.command(cls=Command)
@click.argument("shell", type=click.Choice(SHELLS))
def command(settings: Settings, shell: str) -> Report:
    """Print the completion script for your SHELL.

    \b
    bash:  eval "$(tissuec completion bash)"      in ~/.bashrc
    zsh:   eval "$(tissuec completion zsh)"       in ~/.zshrc
    fish:  tissuec completion fish | source       in ~/.config/fish/config.fish
    """
    from tissuec.cli import group

    kind = get_completion_class(shell)
    assert kind is not None
    script = kind(group, {}, "tissuec", "_TISSUEC_COMPLETE").source()
    return Report([Verbatim(f"{script}\n")], {"shell": shell, "script": script})
