"""The commands and their options, as Markdown, from the commands themselves."""

from inspect import cleandoc

import click

from tissuec.cli import group
from tissuec.cli.common import FLAGS
from tissuec.core.markdown import code, paragraphs, table

PROGRAM = "tissuec"


def parts() -> dict[str, str]:
    """Return every generated part of the page of commands by its name."""
    context = click.Context(group, info_name=PROGRAM)
    names = group.list_commands(context)
    flags = [param for param in group.params if param.name in FLAGS]
    return {
        "global options": _options(flags, context),
        "commands": "\n\n".join(_sections(group, name, context) for name in names),
    }


def _sections(parent: click.Group, name: str, above: click.Context) -> str:
    """Return the section of a command, followed by those of its own commands."""
    command = parent.get_command(above, name)
    assert command is not None
    context = click.Context(command, info_name=name, parent=above)
    sections = [_section(command, context)]
    if isinstance(command, click.Group):
        sections += [
            _sections(command, inner, context) for inner in command.list_commands(context)
        ]
    return "\n\n".join(sections)


def _section(command: click.Command, context: click.Context) -> str:
    usage = " ".join([context.command_path, *command.collect_usage_pieces(context)])
    options = [p for p in command.params if isinstance(p, click.Option) and not p.hidden]
    own = [option for option in options if option.name not in FLAGS]
    parts = [
        f"## `{context.command_path}`",
        f"```text\n{usage}\n```",
        paragraphs(cleandoc(command.help or "")),
    ]
    return "\n\n".join([*parts, *([_options(own, context)] if own else [])])


def _options(options: list, context: click.Context) -> str:
    rows = []
    for option in options:
        spelling, text = option.get_help_record(context)
        rows.append((code(spelling), text))
    return table(("option", "meaning"), rows)
