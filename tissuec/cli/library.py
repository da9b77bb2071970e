"""``tissuec library``: List the shipped library, or copy a part of it."""

from pathlib import Path

import click

from tissuec.cli.common import Command, CommandGroup, Settings
from tissuec.cli.completing import shipped_names
from tissuec.core import resources
from tissuec.core.errors import TissueError
from tissuec.core.files import write_file
from tissuec.core.hints import did_you_mean
from tissuec.core.report import FactSection, FactTable, Part, Report

KINDS = {
    "scenes": "scenes to run",
    "tissues": "tissues of springs to use",
    "matter": "tissues of matter to use, for bodies of any shape",
    "fuzzy": "vocabularies",
    "meshes": "meshes to use",
}


@click.group(cls=CommandGroup, invoke_without_command=True)
@click.pass_context
def command(ctx: click.Context, settings: Settings) -> Report | None:
    """List the shipped library, or copy a part of it to edit.

    \b
    tissuec library
    tissuec library copy sterilisation
    """
    return shipped() if ctx.invoked_subcommand is None else None


@command.command("list", cls=Command)
def listing(settings: Settings) -> Report:
    """List vocabularies, tissues and scenes with one line each."""
    return shipped()


def shipped() -> Report:
    """Return a line on everything that is shipped."""
    entries, parts = _entries(), list[Part]()
    for kind, title in KINDS.items():
        rows = [(entry["name"], entry["about"]) for entry in entries if entry["kind"] == kind]
        table = FactTable((), rows, least=(28,))
        parts.append(FactSection(f"{title}:", [table], apart=False))
    parts.append("\nto copy one and edit it: tissuec library copy NAME")
    return Report(parts, entries)


@command.command("copy", cls=Command)
@click.argument("name", shell_complete=shipped_names(*KINDS, short=True, files=False))
@click.argument("destination", default=".", type=click.Path(path_type=Path))
@click.option("--force", is_flag=True, help="Replace an existing file.")
def copy(settings: Settings, name: str, destination: Path, force: bool) -> Report:
    """Copy the shipped file NAME to DESTINATION, a folder or a new file name."""
    entry = _find(name)
    target = destination / Path(entry["file"]).name if destination.is_dir() else destination
    if target.exists() and not force:
        raise TissueError(f'"{target}" exists; use --force to replace it, or name another file')
    write_file(target, Path(entry["file"]).read_bytes())
    what = f"{entry['kind']}/{entry['name']}"
    document = {"copied": what, "to": str(target)}
    return Report([f"copied {what} to {target}"], document, level="remark")


def _entries() -> list[dict[str, str]]:
    """Return kind, name, file and first line of description of everything shipped."""
    return [
        {"kind": kind, "name": path.stem, "about": _about(path), "file": str(path)}
        for kind in KINDS
        for path in sorted((resources.library() / kind).iterdir())
        if path.suffix in (".tis", ".obj")
    ]


def _about(path: Path) -> str:
    """Return the first ``about`` of a file; read as text, for it is only for show."""
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.strip().startswith("about "):
            return line.split('"')[1] if line.count('"') > 1 else ""
    return ""


def _find(name: str) -> dict[str, str]:
    wanted = name.removesuffix(".tis").removesuffix(".obj")
    entries = _entries()
    for entry in entries:
        if wanted in (entry["name"], f"{entry['kind']}/{entry['name']}"):
            return entry
    hint = did_you_mean(wanted, [entry["name"] for entry in entries])
    raise TissueError(
        f'the library does not contain "{name}"'
        + (f"; {hint}" if hint else "; to list the library: tissuec library")
    )
