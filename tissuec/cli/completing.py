"""What the shell completes after a command: shipped names, files, and params of a scene.

The user of a shell waits, so that nothing is compiled here: texts are only taken apart
into statements.
"""

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import cast

import click
from click.shell_completion import CompletionItem, split_arg_string

from tissuec.core import resources
from tissuec.core.names import key_of

SUFFIX = ".tis"
#: Bytes of a scene; those of a longer one are not looked through.
LARGEST = 5_000_000

Complete = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def shipped_names(*folders: str, short: bool = False, files: bool = True) -> Complete:
    """Return a function that completes names of shipped files.

    Args:
        folders: Of the library, such as "fuzzy".
        short: Whether names without their folder count as well.
        files: Whether the user's own files are completed as well.
    """

    def complete(
        ctx: click.Context, parameter: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        paths = [
            path
            for folder in folders
            for path in sorted((resources.library() / folder).glob(f"*{SUFFIX}"))
        ]
        names = [f"{path.parent.name}/{path.stem}" for path in paths]
        if short:
            names = [*dict.fromkeys(path.stem for path in paths), *names]
        found = [CompletionItem(name) for name in names if name.startswith(incomplete)]
        return [*found, *([CompletionItem(incomplete, type="file")] if files else [])]

    return complete


def params(
    ctx: click.Context, parameter: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Return the params of the scenes on the command line, with their values.

    Args:
        parameter: The parameter to complete.
        incomplete: The text so far.
    """
    given = [text for text in ctx.params.get(parameter.name or "") or () if "=" in text]
    known = {key_of(text.split("=")[0]) for text in given}
    found: dict[str, str] = {}
    for path in _scenes(ctx):
        for name, value in params_of(path):
            found.setdefault(name, value)
    return [
        CompletionItem(_quoted(f"{name}={value}"))
        for name, value in found.items()
        if name.startswith(incomplete.strip("'\"")) and key_of(name) not in known
    ]


def _scenes(ctx: click.Context) -> Iterable[Path]:
    """Return the scenes that are named before the place of the cursor, or after it."""
    named = [value for value in ctx.params.values() if value]
    values: list[object] = []
    for value in named:
        values += cast("tuple[object, ...]", value) if isinstance(value, tuple) else [value]
    words = split_arg_string(os.environ.get("COMP_WORDS", ""))
    paths = [Path(str(value)) for value in (*values, *words)]
    return [path for path in dict.fromkeys(paths) if path.suffix == SUFFIX and path.is_file()]


def params_of(path: Path) -> list[tuple[str, str]]:
    """Return the names and values of the params that a text declares, in order."""
    from tissuec.core.source import Source
    from tissuec.lang.tree_builder import tree_of  # late: needed after --set only

    try:
        if path.stat().st_size > LARGEST:
            return []
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return []
    found: list[tuple[str, str]] = []
    for statement in tree_of(Source(path.name, text)).statements:
        parts = statement.parts
        signs = [part.text for part in parts]
        if signs[:1] != ["param"] or "=" not in signs:
            continue
        sign = parts[signs.index("=")]
        end = next((part.start for part in parts if part.text == "between"), parts[-1].stop)
        name = text[parts[0].stop : sign.start].strip().strip('"')
        found.append((" ".join(name.split()), " ".join(text[sign.stop : end].split())))
    return found


def _quoted(text: str) -> str:
    """Return a text as bash takes it for one word; other shells quote by themselves."""
    if not os.environ.get("_TISSUEC_COMPLETE", "").startswith("bash"):
        return text
    return "".join(f"\\{sign}" if sign in " ()*'\"$&;|<>" else sign for sign in text)
