"""``tissuec validate``: Compare a run with SciPy's solvers."""

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from tissuec.cli.common import Command, SceneOptions, Settings, scene_options
from tissuec.core.progress import RunProgress
from tissuec.core.report import Report

if TYPE_CHECKING:
    from tissuec.compiler.compile import Compiled

METHODS = ("DOP853", "RK45", "RK23", "Radau", "BDF", "LSODA")


@click.command(cls=Command)
@click.argument("scene", type=click.Path(path_type=Path))
@click.option(
    "--method",
    type=click.Choice(METHODS, case_sensitive=False),
    help=f"SciPy's solver, {METHODS[0]} by default; Radau, BDF and LSODA suit stiff and "
    "strongly damped scenes.",
)
@click.option(
    "--rtol",
    type=click.FloatRange(1e-13, 1e-2),
    metavar="X",
    help="Relative tolerance of SciPy's solver. Default: a thousandth of the tolerance "
    "of the scene, or less if necessary.",
)
@click.option(
    "--mesh",
    "halvings",
    type=click.IntRange(min=1),
    is_flag=False,
    flag_value=1,
    metavar="[N]",
    help="Compare with a mesh whose cells are half as long instead, or with N finer and finer "
    "meshes, and estimate the error of the mesh.",
)
@scene_options
def command(
    settings: Settings,
    scene: Path,
    method: str | None,
    rtol: float | None,
    halvings: int | None,
    given: SceneOptions,
) -> Report:
    """Run SCENE, solve it again with SciPy, and compare the errors with the tolerance.

    The tolerance concerns time steps. With --mesh, SCENE is run again with finer meshes of its
    bodies of elements instead, and displacements at the end and logs are compared.

    No file is written. A second SciPy solution checks the first. Exit code: 0 errors are within
    their limits, or a fixed step has none; 1 they exceed them, or SciPy's solution is not
    accurate enough to decide; 2 the text is wrong; 3 the run could not continue. With --mesh,
    there are no limits: the exit code is 0 if all runs finish, otherwise 2 or 3.
    """
    from tissuec.pipeline import compile_request
    from tissuec.validate.report import validation_report

    if halvings is not None:
        if method is not None or rtol is not None:
            raise click.UsageError(
                "--method and --rtol are for SciPy's solution, which --mesh does not need: "
                "leave them out, or --mesh"
            )
        return _refined(settings, scene, halvings, given)
    compiled, warnings = compile_request(given.request(scene))
    facts = {"scene": str(scene), "diagnostics": settings.warn(warnings)}
    return validation_report(validated(compiled, method or METHODS[0], rtol, settings), facts)


def _refined(settings: Settings, scene: Path, halvings: int, given: SceneOptions) -> Report:
    """Return the report on runs with finer and finer meshes; show their progress."""
    from tissuec.pipeline import compile_request
    from tissuec.validate.refinement import MeshRun, dependences, mesh_run
    from tissuec.validate.refinement_report import refinement_report

    request, runs = given.request(scene), list[MeshRun]()
    first, warnings = compile_request(request)
    facts = {"scene": str(scene), "diagnostics": settings.warn(warnings)}
    meshes = [first, *(compile_request(request, halvings=n + 1)[0] for n in range(halvings))]
    with Stages(first.plan.simulation.duration, settings) as stages:
        for compiled in meshes:
            stage = f"run with {compiled.network.size}"
            runs.append(mesh_run(compiled, lambda time, stage=stage: stages.at(stage, time)))
            if runs[-1].outcome.kind != "done":
                return refinement_report(runs, (), facts)
    return refinement_report(runs, dependences(first, runs), facts)


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
            shown = self.settings.shows_progress
            line = RunProgress(stage, self.duration, shown=shown, compiles=stage == "run")
            self.line = self.enter_context(line)
        self.line.at(time)
