"""``tissuec validate``: Compare a run with SciPy's solvers."""

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tissuec.cli.common import (
    DONE,
    FAILED,
    STOPPED,
    WRONG_TEXT,
    Command,
    Settings,
    as_json,
    echo,
    print_json,
    report,
    scene_options,
    tell_mistakes,
)
from tissuec.core.errors import CompileError
from tissuec.core.progress import RunProgress

if TYPE_CHECKING:
    from tissuec.compiler.compile import Compiled

METHODS = ("DOP853", "RK45", "RK23", "Radau", "BDF", "LSODA")
CODES = {
    "kept": DONE,
    "nothing promised": DONE,
    "broken": FAILED,
    "undecided": FAILED,
    "diverged": STOPPED,
}


@click.command(cls=Command)
@click.argument("scene", type=click.Path(path_type=Path))
@click.option(
    "--method",
    type=click.Choice(METHODS, case_sensitive=False),
    default="DOP853",
    show_default=True,
    help="SciPy's solver; Radau, BDF and LSODA suit stiff and strongly damped scenes.",
)
@click.option(
    "--rtol",
    type=click.FloatRange(1e-13, 1e-2),
    metavar="X",
    help="Relative tolerance of SciPy's solver. Default: a thousandth of the tolerance "
    "of the scene, or less if necessary.",
)
@scene_options
def command(
    settings: Settings,
    scene: Path,
    method: str,
    rtol: float | None,
    overrides: tuple[str, ...],
    libraries: tuple[Path, ...],
    strict: bool,
) -> int:
    """Run SCENE, solve it again with SciPy, and compare the errors with the tolerance.

    No file is written. A second SciPy solution checks the first. Exit code: 0 errors are within
    their limits, or a fixed step has none; 1 they exceed them, or SciPy's solution is not
    accurate enough to decide; 2 the text is wrong; 3 the run could not continue.
    """
    from tissuec.pipeline import compile_request
    from tissuec.scene.request import Request

    try:
        request = Request.file(scene, overrides=overrides, libraries=libraries, strict=strict)
        compiled, warnings = compile_request(request)
    except CompileError as error:
        tell_mistakes(error, settings, scene=str(scene))
        return WRONG_TEXT
    if not settings.json:
        report(warnings, settings)
    document = validated(compiled, method, rtol, settings)
    code = CODES[document["verdict"]]
    if settings.json:
        facts = {"scene": str(scene), "ok": code == DONE, "diagnostics": as_json(warnings)}
        print_json(facts | document)
    else:
        _tell(document)
    return code


def validated(
    compiled: "Compiled", method: str, rtol: float | None, settings: Settings
) -> dict[str, Any]:
    """Return all numbers of a comparison, or only why there are none; show its progress.

    Args:
        compiled: The scene.
        method: Of SciPy, for the reference.
        rtol: Error per step of the reference; None derives it from the tolerance.
        settings: Global flags.
    """
    from tissuec.validate.report import as_dict
    from tissuec.validate.stepping import ReferenceFailure
    from tissuec.validate.validation import validate

    try:
        with Stages(compiled.plan.simulation.duration, settings) as stages:
            validation = validate(compiled, method=method, rtol=rtol, progress=stages.at)
    except ReferenceFailure as failure:
        return {"verdict": "undecided", "reasons": [str(failure)]}
    return as_dict(validation, compiled.network)


def _tell(document: dict[str, Any]) -> None:
    from tissuec.validate.summary import as_text

    if "run" in document:
        echo("\n".join(as_text(document)))
    else:
        echo(f"error: {document['reasons'][0]}", err=True)


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
            line = RunProgress(stage, self.duration, shown=shown, compiles=stage == "run")
            self.line = self.enter_context(line)
        self.line.at(time)
