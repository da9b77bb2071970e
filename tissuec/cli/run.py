"""``tissuec run``: Simulate scenes and write their motion to HDF5."""

import gc
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import click

from tissuec.cli import USUAL_THRESHOLDS
from tissuec.cli.common import (
    PAGES,
    Command,
    Reports,
    SceneOptions,
    Settings,
    keep_input,
    scene_options,
)
from tissuec.core.errors import CompileError, TissueError
from tissuec.core.report import STOPPED, WRONG_TEXT, Report, failed
from tissuec.core.structs import replace
from tissuec.results import PRECISIONS, SINGLE

if TYPE_CHECKING:
    from tissuec.compiler.compile import Compiled
    from tissuec.engine.execution.companion import Mode

RESULTS = (".vtkhdf", ".h5", ".hdf5", ".hdf")  # endings of results
# Springs and edges from which memory counts more than the time of searching for cycles.
LARGE = 1_000_000


@click.command(cls=Command)
@click.argument("scenes", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Result file (one scene only).",
)
@click.option(
    "--out",
    "folder",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder for results.",
    metavar="DIR",
)
@click.option("--resume", is_flag=True, help="Resume an interrupted run.")
@click.option(
    "--companion",
    type=click.Choice(["auto", "process", "inline", "off"]),
    default="auto",
    help="How the companion run, with smaller steps of another method, estimates the error: "
    "in another process, afterwards in this one (inline), whichever is faster (auto), or not "
    "at all.",
)
@click.option(
    "--threads",
    type=click.IntRange(min=1),
    help="Maximum number of threads for a large net; by default one for each processor, or "
    "half as many if the companion run may use the others. Results do not depend on it.",
)
@click.option(
    "--blocks",
    is_flag=True,
    help="Also write a blocks file for ParaView, with the parts of bodies, joints and tools.",
)
@click.option(
    "--precision",
    type=click.Choice(list(PRECISIONS)),
    help="Precision of frames and surfaces in the result, instead of that of the scene.",
)
@click.option("--compress", is_flag=True, help="Compress frames and surfaces, without loss.")
@click.option("--twin/--no-twin", default=None, hidden=True, help="Former names: auto, off.")
@scene_options
def command(
    settings: Settings,
    scenes: tuple[Path, ...],
    output: Path | None,
    folder: Path | None,
    resume: bool,
    companion: "Mode",
    threads: int | None,
    blocks: bool,
    precision: str | None,
    compress: bool,
    twin: bool | None,
    given: SceneOptions,
) -> Reports:
    """Simulate SCENES; scene.tis gives scene.vtkhdf in the current directory.

    ParaView, H5MD readers and h5py open the result. When the run ends, it replaces an earlier
    result of the same name, but no other file. Exit code: 0 done; 1 an expectation failed, the
    run ended too early to check one or, with --strict, numbers are doubtful or their error
    exceeds the tolerance or is unknown; 2 the text or the command line is wrong; 3 the run
    could not continue; 130 interrupted (143 by SIGTERM, 129 by SIGHUP).
    """
    _check_endings(output, folder)
    if output is not None and (len(scenes) > 1 or folder is not None):
        raise click.UsageError("-o names the result of one scene; use --out DIR for several")
    storage = _Storage(precision, compress)
    if resume and storage.is_asked_for:
        raise click.UsageError(
            "a resumed run keeps the storage with which it began: omit --precision and "
            "--compress"
        )
    order = _RunOrder(
        resume, "off" if twin is False else companion, threads, blocks, storage, output, folder,
        given,
    )  # fmt: skip
    targets = _targets(scenes, output, folder)
    each = (_run(path, target, order, settings) for path, target in targets.items())
    return Reports(each, len(scenes) > 1)


class _RunOrder(NamedTuple):
    """Options that are the same for all scenes; see the options of the command."""

    resume: bool
    companion: "Mode"
    threads: int | None
    blocks: bool
    storage: "_Storage"
    output: Path | None
    folder: Path | None
    given: SceneOptions

    def again(self, path: Path) -> str:
        """Return the command line that resumes the run of a scene."""
        from tissuec.scene.request import run_command, set_options

        options = [
            ("-o", self.output), ("--out", self.folder),
            *set_options(self.given.overrides, self.given.libraries),
        ]  # fmt: skip
        return run_command(
            path, options, resume=True, strict=self.given.strict, blocks=self.blocks
        )


class _Storage(NamedTuple):
    """How frames are stored, as far as the command line says it."""

    precision: str | None
    compress: bool

    @property
    def is_asked_for(self) -> bool:
        """Return whether it differs from what the scene says."""
        return self.compress or self.precision is not None

    def of(self, compiled: "Compiled") -> "Compiled":
        """Return a scene with this storage; PlaceError if it stores no frames."""
        from tissuec.results import PlaceError

        output = compiled.plan.output
        if not self.is_asked_for:
            return compiled
        if not (len(output.frames) or output.surfaces):
            option = "--compress" if self.compress else "--precision"
            raise PlaceError(
                f"{compiled.scene.source.name} records no frames for {option}; write in the "
                "scene: output { trajectory every 10 ms }"
            )
        single = output.single if self.precision is None else self.precision == SINGLE
        output = replace(output, single=single, compress=self.compress or output.compress)
        return replace(compiled, plan=replace(compiled.plan, output=output))


#: What writes files of other kinds from a result, by their endings.
_OTHERS = {
    "export": (
        ".csv",
        ".tsv",
        ".txt",
        ".xlsx",
        ".json",
        ".vtk",
        ".vtu",
        ".pvd",
        ".stl",
        ".obj",
    ),
    "plot": (".png", ".svg", ".pdf", ".jpg", ".jpeg"),
    "view": (*PAGES, ".mp4", ".gif", ".webm"),
}


def _check_endings(output: Path | None, folder: Path | None) -> None:
    """Refuse names of results that promise another kind of file, or a file for a folder.

    Raises:
        UsageError: A name ends so.
    """
    if folder is not None and folder.suffix.lower() in RESULTS and not folder.is_dir():
        raise click.UsageError(f'--out names a folder; for a file, write "-o {folder}"')
    if output is None:
        return
    for other, endings in _OTHERS.items():
        if output.suffix.lower() in endings:
            result = output.with_suffix(".vtkhdf")
            raise click.UsageError(
                f'a result is an HDF5 file, unlike "{output}"; write "-o {result}", and then: '
                f"tissuec {other} {result}"
            )


def _targets(
    scenes: tuple[Path, ...], output: Path | None, folder: Path | None
) -> dict[Path, Path]:
    """Return where the result of each scene goes; TissueError if that would lose a file."""
    from tissuec.results.places import SUFFIX, final_path, partial_path

    targets: dict[Path, Path] = {}
    owners: dict[Path, Path] = {}
    for path in scenes:
        target = targets[path] = output or (folder or Path()) / f"{path.stem}{SUFFIX}"
        partial = partial_path(target)
        if path.suffix != SUFFIX:  # a result that is given as a scene is refused as such
            for place in (partial, final_path(partial)):
                keep_input(place, path)
        owner = owners.setdefault(final_path(partial).resolve(), path)
        if owner is not path:
            raise TissueError(
                f'the results of "{owner}" and "{path}" would both be "{target}"; run one of '
                "them separately, with -o"
            )
    return targets


def _run(path: Path, target: Path, order: _RunOrder, settings: Settings) -> Report:
    """Return the report on a scene that is run."""
    from tissuec.core.progress import RunProgress, compiling
    from tissuec.pipeline import compile_request, simulate
    from tissuec.results import PlaceError
    from tissuec.results.places import make_folder
    from tissuec.view.run_summary import run_report

    scene, shown = str(path), settings.shows_progress
    try:
        request = order.given.request(path)
        with compiling(request.source.name, shown=shown):
            compiled, warnings = compile_request(request)
    except CompileError as error:
        return Report((), {"scene": scene}, WRONG_TEXT, error.diagnostics)
    settings.warn(warnings)
    if compiled.network.line_count > LARGE:
        gc.set_threshold(*USUAL_THRESHOLDS)
    try:
        make_folder(target.parent)
        compiled = order.storage.of(compiled)
        duration = compiled.plan.simulation.duration
        with RunProgress(request.source.name, duration, shown=shown) as progress:
            result = simulate(
                compiled, target, request=request, resume=order.resume,
                companion=order.companion, threads=order.threads, blocks=order.blocks,
                progress=progress.at,
            )  # fmt: skip
    except TissueError as error:
        code = WRONG_TEXT if isinstance(error, PlaceError) else STOPPED
        return failed(error, code, scene=scene)
    again = order.again(path)
    return run_report(
        scene, compiled, result, warnings, again, strict=order.given.strict,
        details=settings.verbose,
    )  # fmt: skip
