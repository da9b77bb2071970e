"""``tissuec check``: Check scenes for mistakes without simulating."""

from pathlib import Path

import click

from tissuec.cli.common import Command, SceneOptions, Settings, scene_options
from tissuec.core.errors import CompileError, Diagnostic, as_dict, counted
from tissuec.core.progress import compiling
from tissuec.core.report import DONE, WRONG_TEXT, Report
from tissuec.core.structs import replace


@click.command(cls=Command)
@click.argument("scenes", nargs=-1, required=True, type=click.Path(path_type=Path))
@scene_options
def command(
    settings: Settings,
    scenes: tuple[Path, ...],
    given: SceneOptions,
) -> Report:
    """Check SCENES for mistakes without simulating.

    This builds the meshes, evaluates the sets, and reads the script and the data of learn
    blocks, so a scene that passes can run. Files without a body (vocabularies, tissues) are
    also checked.
    """
    found: list[Diagnostic] = []
    for path in scenes:
        with compiling(path.name, shown=settings.shows_progress):
            diagnostics, counts = _check(path, given)
        found += diagnostics
        settings.warn(diagnostics)
        settings.show(f"{path}: {_counted(diagnostics)}{counts}", level="remark")
    failed = any(one.severity == "error" or given.strict for one in found)
    document = {"diagnostics": [*map(as_dict, found)]}
    return Report((), document, WRONG_TEXT if failed else DONE)


def _counted(diagnostics: list[Diagnostic]) -> str:
    """Return "2 errors, 1 warning", or "good"."""
    counts = [
        counted(number, severity)
        for severity in ("error", "warning")
        if (number := sum(one.severity == severity for one in diagnostics))
    ]
    return ", ".join(counts) or "good"


def _check(path: Path, given: SceneOptions) -> tuple[list[Diagnostic], str]:
    """Return the diagnostics of a file, and the size of its scene."""
    from tissuec.compiler.checks.nets import uncounted
    from tissuec.pipeline import check_request

    try:
        compiled, warnings = check_request(replace(given, strict=False).request(path))
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
