"""``tissuec validate``"""

from contextlib import ExitStack
from pathlib import Path
from typing import Any

import click

from tissuec.cli.common import (
    DONE, FAILED, STOPPED, WRONG_TEXT, Command, Settings, as_json, print_json, report, scene_options,
)  # fmt: skip
from tissuec.cli.progress import Progress
from tissuec.core.errors import CompileError

METHODS = ("DOP853", "RK45", "RK23", "Radau", "BDF", "LSODA")
_CODES = {
    "kept": DONE,
    "nothing promised": DONE,
    "broken": FAILED,
    "undecided": FAILED,
    "diverged": STOPPED,
}


@click.command(cls=Command)
@click.argument("scene", type=click.Path(path_type=Path))
@click.option("--method", type=click.Choice(METHODS, case_sensitive=False), default="DOP853", show_default=True,
              help="SciPy's solver; Radau, BDF and LSODA are for strongly damped or stiff scenes.")  # fmt: skip
@click.option("--rtol", type=click.FloatRange(1e-13, 1e-2), metavar="X",
              help="Error per step of the reference; by default a thousandth of the tolerance, and less if need be.")  # fmt: skip
@scene_options
def command(
    settings: Settings, scene: Path, method: str, rtol: float | None,
    overrides: tuple[str, ...], libraries: tuple[Path, ...], strict: bool,
) -> int:  # fmt: skip
    """Run SCENE, solve it again with SciPy, and compare both with what the tolerance promises.

    Nothing is written. The solution by SciPy is itself checked by a second one. Exit code: 0
    the promise is kept, or a fixed step promises nothing; 1 it is broken, or the solution by
    SciPy is not known well enough to tell; 2 the text is wrong; 3 the run could not go on.
    """
    from tissuec.pipeline import Request, compile_request
    from tissuec.validate.report import as_dict, as_text
    from tissuec.validate.stepping import ReferenceFailure
    from tissuec.validate.validation import validate

    try:
        request = Request.file(scene, overrides=overrides, libraries=libraries, strict=strict)
        compiled, warnings = compile_request(request)
    except CompileError as error:
        return _wrong(scene, error, settings)
    document: dict[str, Any] = {
        "scene": str(scene),
        "ok": False,
        "diagnostics": as_json(warnings),
    }
    if not settings.json:
        report(warnings, settings)
    try:
        with Stages(compiled.plan.simulation.duration, settings) as stages:
            validation = validate(compiled, method=method, rtol=rtol, progress=stages.at)
    except ReferenceFailure as failure:
        if settings.json:
            print_json(document | {"verdict": "undecided", "reasons": [str(failure)]})
        else:
            click.echo(f"error: {failure}", err=True)
        return FAILED
    code = _CODES[validation.verdict]
    if settings.json:
        print_json(document | {"ok": code == DONE, **as_dict(validation, compiled.network)})
    else:
        click.echo("\n".join(as_text(validation, compiled.network)))
    return code


def _wrong(scene: Path, error: CompileError, settings: Settings) -> int:
    if settings.json:
        print_json(
            {"scene": str(scene), "ok": False, "diagnostics": as_json(error.diagnostics)}
        )
    else:
        report(error.diagnostics, settings)
    return WRONG_TEXT


class Stages(ExitStack):
    """Says on stderr which stage has begun, with a progress line of its own."""

    def __init__(self, duration: float, settings: Settings):
        super().__init__()
        self.duration, self.settings = duration, settings
        self.stage = ""

    def at(self, stage: str, time: float) -> None:
        """Show that a stage has come to a simulated time [s]."""
        if stage != self.stage:
            self.close()
            self.stage = stage
            self.settings.say(f"{stage} …")
            shown = not (self.settings.quiet or self.settings.json)
            self.line = self.enter_context(Progress(stage, self.duration, shown=shown))
        self.line.at(time)
