"""``tissuec check``: Check scenes for mistakes without simulating."""

from pathlib import Path

import click

from tissuec.cli.common import (
    DONE,
    WRONG_TEXT,
    Command,
    Settings,
    as_json,
    print_json,
    report,
    scene_options,
    summary,
)  # fmt: skip
from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.progress import compiling


@click.command(cls=Command)
@click.argument("scenes", nargs=-1, required=True, type=click.Path(path_type=Path))
@scene_options
def command(
    settings: Settings,
    scenes: tuple[Path, ...],
    overrides: tuple[str, ...],
    libraries: tuple[Path, ...],
    strict: bool,
) -> int:
    """Check SCENES for mistakes without simulating.

    This builds the meshes, evaluates the sets and reads the script, so a scene that passes can
    run. Files without a body (vocabularies, tissues) are also checked.
    """
    found: list[Diagnostic] = []
    for path in scenes:
        with compiling(path.name, shown=settings.shows_progress):
            diagnostics, counts = _check(path, overrides, libraries)
        found += diagnostics
        if not settings.json:
            report(diagnostics, settings)
            errors = sum(d.severity == "error" for d in diagnostics)
            result = summary(errors, len(diagnostics) - errors) or "good"
            settings.say(f"{path}: {result}{counts}")
    failed = any(d.severity == "error" or strict for d in found)
    if settings.json:
        print_json({"ok": not failed, "diagnostics": as_json(found)})
    return WRONG_TEXT if failed else DONE


def _check(
    path: Path, overrides: tuple[str, ...], libraries: tuple[Path, ...]
) -> tuple[list[Diagnostic], str]:
    """Return what is to be said about a file, and how large its scene is."""
    from tissuec.compiler.net_checks import uncounted
    from tissuec.pipeline import check_request
    from tissuec.scene.request import Request

    try:
        request = Request.file(path, overrides=overrides, libraries=libraries)
        compiled, warnings = check_request(request)
    except CompileError as error:
        return list(error.diagnostics), ""
    if compiled is None:
        return list(warnings), ""
    network = compiled.network
    parts = [str(network.size)]
    if bending := int(network.bends.sum()):
        parts[-1] += f", {bending} of them bending springs"
    if too_large := uncounted(compiled):
        parts.append(f"floppy modes not checked: {', '.join(too_large)} too large")
    return list(warnings), f" ({', '.join(parts)})"
