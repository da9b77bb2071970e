"""tissuec from Python: a scene is checked, compiled or run, and its result read."""

import os
import signal
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias, TypeGuard

from tissuec.core import arguments
from tissuec.core.blas import on_one_thread
from tissuec.core.errors import (
    CompileError,
    Diagnostic,
    ExpectationError,
    SimulationError,
    TissueError,
    TissueWarning,
)
from tissuec.core.structs import replace

if TYPE_CHECKING:
    from tissuec.analysis.bodies import BodyProperties
    from tissuec.analysis.lab.laboratory import Examination
    from tissuec.analysis.vibration.modes import Modes
    from tissuec.api.environment import TissueEnv
    from tissuec.api.notebook import Trajectory
    from tissuec.api.stepped_run import SteppedRun
    from tissuec.api.study_table import StudyTable
    from tissuec.compiler.compile import Compiled
    from tissuec.engine.execution.companion import Mode
    from tissuec.engine.execution.run import Outcome
    from tissuec.scene.overrides.texts import Given
    from tissuec.scene.request import Request

#: The text of a scene, or the file that holds it.
Scene: TypeAlias = "str | os.PathLike[str]"
TEXT = "scene"  # what a text is called in messages
UNUSED = ("W501", "W502")  # findings about params, sets and others that nothing in a text uses


def load(path: str | os.PathLike[str]) -> "Trajectory":
    """Return a result file, also that of a run that is not finished.

    Raises:
        ResultError: There is none, or it is truncated, or no result.
    """
    from tissuec.api.notebook import Trajectory

    return Trajectory(Path(path))


@on_one_thread
def run(
    scene: Scene,
    *,
    out: str | os.PathLike[str] | None = None,
    params: "Mapping[str, Given] | None" = None,
    strict: bool = False,
    progress: bool | Callable[[float], None] = False,
    resume: bool = False,
    companion: "Mode" = "auto",
    threads: int | None = None,
    libraries: Sequence[str | os.PathLike[str]] = (),
    **more: "Given",
) -> "Trajectory":
    """Run a scene and return its result.

    Args:
        scene: A file, or the text itself: a string of several lines or one that begins with
            "language".
        out: The result file; by default a temporary one, which is removed together with the
            returned object. `Trajectory.save` keeps it.
        params: Values of params by name: texts such as "0.9 s", or numbers and vectors in SI
            units.
        strict: Whether warnings about the text, an unfinished run, failed expectations, doubts
            and a broken promise are errors. By default they are Python warnings.
        progress: Whether to show a line on stderr; or a function to call with the simulated
            time [s] now and then.
        resume: Whether to resume the interrupted run of ``out``.
        companion: How a run with finer steps of another method estimates the error of
            positions: in a "process" beside the run, "inline" after it, by the faster of both
            ("auto"), or not at all ("off"). `Trajectory.promise` is the verdict.
        threads: Maximum number of threads for a large net; by default one for each processor,
            or half as many if the companion may use the others. The motion does not change.
        libraries: Further folders to search for what the scene uses.
        **more: More params; an underscore means a blank, as in ``cut_time="0.9 s"``.

    Raises:
        CompileError: The text is wrong; the message contains all findings with their places.
        ValueError: ``companion`` is none of these words, or ``threads`` is below 1.
        PlaceError: The result cannot be written there, or there is nothing to resume.
        ResultError: Writing failed later.
        SimulationError: With ``strict``, the run diverged, could not continue, broke its
            promise, or has doubtful numbers.
        ExpectationError: With ``strict``, an expectation failed.
        KeyboardInterrupt: After Ctrl-C; the file of ``out`` is complete or can be resumed.
        SystemExit: Likewise after SIGTERM and SIGHUP, with 143 and 129.
    """
    from tissuec.pipeline import simulate
    from tissuec.results.places import result_place

    _check_companion(companion)
    _check_threads(threads)
    compiled, request = _compiled(scene, {**(params or {}), **more}, libraries, strict=strict)
    name, duration = request.source.name, compiled.plan.simulation.duration
    with result_place(out, name) as path:
        with _told(progress, name, duration) as tell:
            result = simulate(
                compiled, path, request=request, resume=resume, companion=companion,
                threads=threads, progress=tell,
            )  # fmt: skip
        return _judged(result.path, result.outcome, strict=strict, temporary=out is None)


@on_one_thread
def start(
    scene: Scene,
    *,
    out: str | os.PathLike[str] | None = None,
    params: "Mapping[str, Given] | None" = None,
    threads: int | None = None,
    libraries: Sequence[str | os.PathLike[str]] = (),
    **more: "Given",
) -> "SteppedRun":
    """Return a run of a scene at 0 s, which you advance step by step.

    Args:
        scene: As of `run`.
        out: The result file that is written when the run is closed; None for none.
        params, threads, libraries, more: As those of `run`.

    Raises:
        CompileError: The text is wrong; the message is all findings with their places.
        ValueError: ``threads`` is below 1.
        PlaceError: The result cannot be written there, or another run is writing it.
        SimulationError: What happens at 0 s ends the run.
    """
    from tissuec.api.stepped_run import SteppedRun
    from tissuec.pipeline import compile_request

    _check_threads(threads)
    request = _request(scene, {**(params or {}), **more}, libraries)
    compiled, found = compile_request(request)
    # What the script does not use may be used later.
    _warn(*(str(finding) for finding in found if finding.code not in UNUSED))
    return SteppedRun(
        compiled, request, out=None if out is None else Path(out), threads=threads
    )


@on_one_thread
def environment(
    scene: Scene,
    *,
    observations: "Sequence[str] | Mapping[str, tuple[float, float]]",
    actions: "Mapping[str, tuple[float, float]]",
    reward: str,
    step: str | float,
    ends: str = "",
    params: "Mapping[str, Given] | None" = None,
    libraries: Sequence[str | os.PathLike[str]] = (),
) -> "TissueEnv":
    """Return a scene as an environment of gymnasium, for controllers that learn.

    Args:
        scene: As of `run`.
        observations: Measures, such as "force of forceps A", or these with their limits in SI
            units.
        actions: Sentences of the script with ``{}`` in place of the number, such as "move
            forceps A by (0, 0, {} mm) using constant speed", with the limits of the number.
        reward: A measure, or an expression of measures.
        step: Time between two actions, such as "25 ms"; each sentence takes that long.
        ends: A condition that ends an episode; empty for none.
        params, libraries: As those of `run`.

    Raises:
        CompileError: The text of the scene, a measure, condition or sentence is wrong.
        TissueError: gymnasium is not installed.
        ValueError: A sentence has no ``{}``, or limits do not ascend.
    """
    try:
        from tissuec.api.environment import TissueEnv
    except ImportError as error:
        raise TissueError(
            'an environment needs gymnasium; install it: pip install "tissuec[gymnasium]"'
        ) from error
    run = start(scene, params=params, libraries=libraries)
    return TissueEnv(run, observations, actions, reward, step=step, ends=ends)


@on_one_thread
def check(
    scene: Scene,
    *,
    params: "Mapping[str, Given] | None" = None,
    libraries: Sequence[str | os.PathLike[str]] = (),
    **more: "Given",
) -> list[Diagnostic]:
    """Return all findings about a scene, errors and warnings; an empty list if there are none.

    A finding as text shows the place, what is wrong and the remedy. A file without a body, such
    as a vocabulary, is checked as such.

    Args:
        scene: As of `run`.
        params: As of `run`.
        libraries: As of `run`.
        more: As of `run`.
    """
    from tissuec.pipeline import check_request

    try:
        return list(check_request(_request(scene, {**(params or {}), **more}, libraries))[1])
    except CompileError as error:
        return list(error.diagnostics)


@on_one_thread
def compile(
    scene: Scene,
    *,
    params: "Mapping[str, Given] | None" = None,
    libraries: Sequence[str | os.PathLike[str]] = (),
    **more: "Given",
) -> "Compiled":
    """Return a scene in arrays, for solvers of your own.

    Args:
        scene: As of `run`.
        params: As of `run`.
        libraries: As of `run`.
        more: As of `run`.

    Raises:
        CompileError: The text is wrong; the message contains all findings with their places.
    """
    return _compiled(scene, {**(params or {}), **more}, libraries)[0]


@on_one_thread
def modes(
    scene: Scene,
    *,
    body: str | None = None,
    count: int = 10,
    above: float | None = None,
    out: str | os.PathLike[str] | None = None,
    params: "Mapping[str, Given] | None" = None,
    libraries: Sequence[str | os.PathLike[str]] = (),
    **more: "Given",
) -> "Modes":
    """Return the natural modes of a scene about its state at 0 s, the lowest first.

    Args:
        scene: As in `run`, like ``params``, ``libraries`` and ``more``.
        body: The only body that moves; everything else stays where it is.
        count: How many, if there are as many.
        above: Leave out the modes at and below this frequency [Hz]; 0 leaves out those that
            nothing resists.
        out: A result file to write if there are any, which plays each mode for a second.

    Raises:
        CompileError: The text is wrong; the message is all findings with their places.
        SimulationError: What happens at 0 s ends a run, or the modes could not be computed.
        TissueError: There is no such body, or nothing can move.
        TypeError, ValueError: ``count`` is no whole number of 1 or more, ``above`` no number.
        PlaceError: The result cannot be written there.
    """
    from tissuec.analysis.vibration.scene import scene_modes
    from tissuec.compiler.manifest import manifest_of

    arguments.count(count, "count")
    if above is not None:
        arguments.number(above, "above")
    compiled, request = _compiled(scene, {**(params or {}), **more}, libraries)
    result = scene_modes(compiled, body=body, count=count, above=above)
    if out is not None and len(result):
        from tissuec.analysis.vibration.scene import write_modes

        write_modes(result, compiled, Path(out), manifest_of(compiled, request))
    return result


@on_one_thread
def properties(
    scene: Scene,
    *,
    body: str | None = None,
    frequencies: int = 3,
    params: "Mapping[str, Given] | None" = None,
    libraries: Sequence[str | os.PathLike[str]] = (),
    **more: "Given",
) -> "list[BodyProperties]":
    """Return the material properties of each body, as ``tissuec explain --bodies`` shows them.

    Args:
        scene: As in `run`, like ``params``, ``libraries`` and ``more``.
        body: Name of a body, to examine it alone.
        frequencies: How many natural frequencies of each body, 0 for none.

    Raises:
        CompileError: The text is wrong; the message is all findings with their places.
        TissueError: There is no such body.
        TypeError, ValueError: ``frequencies`` is no whole number of 0 or more.
    """
    from tissuec.analysis.bodies import properties_of

    arguments.count(frequencies, "frequencies", least=0)
    compiled, _ = _compiled(scene, {**(params or {}), **more}, libraries)
    return list(properties_of(compiled, body=body, frequencies=frequencies))


@on_one_thread
def examine(
    scene: Scene,
    *,
    tissue: str | None = None,
    spacing: float | None = None,
    thickness: float | None = None,
    params: "Mapping[str, Given] | None" = None,
    libraries: Sequence[str | os.PathLike[str]] = (),
    **more: "Given",
) -> "list[Examination]":
    """Return the measurements of tissues in a virtual laboratory, as ``tissuec lab`` does.

    Args:
        scene: A text or a file with tissues.
        tissue: Which one; otherwise those that bodies are made of, or all of the file.
        spacing: Length of cells, if quantities of the tissue belong to springs [m].
        thickness: Of strips of a sheet [m]; bars are tested without it.
        params, libraries, more: As those of `run`.

    Raises:
        CompileError: The text is wrong, or no coupon can be made of a tissue.
        TissueError: There is no such tissue, or nothing of it can be measured.
        TypeError, ValueError: ``spacing`` or ``thickness`` is no number above 0.
    """
    from tissuec.analysis.lab.laboratory import SPACING, chosen
    from tissuec.analysis.lab.laboratory import examine as examine_one
    from tissuec.pipeline import read_words

    for what, length in (("spacing", spacing), ("thickness", thickness)):
        if length is not None:
            arguments.number(length, what, above=0)
    request = _request(scene, {**(params or {}), **more}, libraries)
    words, found = read_words(request)
    _warn(*map(str, found))
    return [
        examine_one(request, one, spacing=spacing or SPACING, thickness=thickness)
        for one in chosen(words, tissue, request.source)
    ]


@on_one_thread
def study(
    scene: Scene,
    name: str | None = None,
    *,
    vary: "str | Sequence[str] | Mapping[str, Given | Iterable[Given]]" = (),
    measure: "str | Sequence[str] | Mapping[str, str]" = (),
    design: str | None = None,
    runs: int | None = None,
    seed: int | None = None,
    sentences: Sequence[str] = (),
    workers: int | None = None,
    scheduler: str | None = None,
    out: str | os.PathLike[str] | None = None,
    fresh: bool = False,
    progress: bool = False,
    params: "Mapping[str, Given] | None" = None,
    libraries: Sequence[str | os.PathLike[str]] = (),
) -> "StudyTable":
    """Run a scene many times and return the table, as ``tissuec study`` does.

    Args:
        scene: As of `run`, like ``libraries`` and ``params``, which hold for every run.
        name: Of the study block; not needed if there is one, or none.
        vary: Factors as texts, such as "lift = 2 mm to 10 mm in 9 steps"; or values by name:
            texts such as "2 mm to 10 mm in 9 steps", or lists of texts or numbers in SI units.
        measure: Measures as texts, such as "pull = max(force(forceps A))"; or by name.
        design: "grid", "list", "one at a time", "latin hypercube", "sobol" or "sobol indices".
        runs, seed: Number of runs of a random design, and which of them.
        sentences: More sentences of the study block, such as "error estimate is off".
        workers: Number of processes; by default one for each processor. 1 is this process.
        scheduler: Address of a dask scheduler whose workers are used instead.
        out: Table to write or to continue, in CSV, or HDF5 if it ends with ".h5"; or none.
        fresh: Whether to discard the rows that ``out`` has already.
        progress: Whether to show the progress on stderr.

    Raises:
        CompileError: The text is wrong, or values do not go with the scene.
        TissueError: There is no such study, or the scheduler cannot be used.
        PlaceError: The table cannot be written there.
        TypeError, ValueError: ``vary`` or ``workers`` is not understood.
    """
    from tissuec.api.study_table import with_methods
    from tissuec.core.workers.selection import workers_of
    from tissuec.studies.report import StudyProgress
    from tissuec.studies.study import prepare, run_study
    from tissuec.studies.writing import sentences_of

    more, crew = arguments.several(sentences, "sentences"), workers_of(workers, scheduler)
    request = _request(scene, params or {}, libraries)
    varied = _texts_of(vary, request) if isinstance(vary, Mapping) else vary
    written = sentences_of(varied, measure, design=design, runs=runs, seed=seed)
    prepared = prepare(request, name, sentences=[*written, *more])
    _warn(*map(str, prepared.warnings))
    with StudyProgress(prepared.study.name, shown=progress, anywhere=True) as line:
        path = None if out is None else Path(out)
        result = run_study(prepared, crew, out=path, fresh=fresh, progress=line.at)
    failed = [verdict for verdict in result.verdicts if not verdict.holds]
    _warn(*(f"{v.span.place}: {v.expect}\n  failed: {v.measured}" for v in failed))
    return with_methods(result.table)


def _check_companion(companion: str) -> None:
    from tissuec.engine.execution.companion import MODES

    if companion not in MODES:
        known = ", ".join(f'"{mode}"' for mode in MODES)
        raise ValueError(f'companion must be one of {known}, not "{companion}"')


def _check_threads(threads: int | None) -> None:
    if threads is not None:
        arguments.count(threads, "threads")


def _texts_of(
    vary: "Mapping[str, Given | Iterable[Given]]", request: "Request"
) -> dict[str, str]:
    """Return factors that are given by name as texts."""
    from tissuec.pipeline import read_words
    from tissuec.scene.overrides.texts import listed

    return listed(vary, read_words(request)[0].constants.parameters())


def _compiled(
    scene: Scene,
    given: "Mapping[str, Given]",
    libraries: Sequence[str | os.PathLike[str]],
    *,
    strict: bool = False,
) -> "tuple[Compiled, Request]":
    """Return a compiled scene and its request; findings are warnings."""
    from tissuec.pipeline import compile_request

    request = _request(scene, given, libraries, strict=strict)
    compiled, found = compile_request(request)
    _warn(*map(str, found))
    return compiled, request


def _request(
    scene: Scene,
    given: "Mapping[str, Given]",
    libraries: Sequence[str | os.PathLike[str]],
    *,
    strict: bool = False,
) -> "Request":
    """Return the request to compile; CompileError if the scene cannot be read."""
    from tissuec.lang.characters import normalise
    from tissuec.pipeline import compile_request, read_words
    from tissuec.scene.program.imports import ParsedOnce, read_source
    from tissuec.scene.request import Request

    source = normalise(scene, TEXT) if _is_text(scene) else read_source(Path(scene))
    folders = tuple(map(Path, arguments.several(libraries, "libraries")))
    request = Request(source, (), folders, strict, ParsedOnce())
    if not given:
        return request
    from tissuec.scene.overrides.texts import overrides

    try:
        known = read_words(request)[0].constants.parameters()
    except CompileError:
        compile_request(request)  # reports all that is wrong, not only words
        raise
    return replace(request, overrides=overrides(given, known))


def _is_text(scene: Scene) -> TypeGuard[str]:
    """Return whether a string is a scene rather than the name of a file."""
    return isinstance(scene, str) and ("\n" in scene or scene.split()[:1] == ["language"])


@contextmanager
def _told(
    progress: bool | Callable[[float], None], name: str, duration: float
) -> Generator[Callable[[float], None] | None]:
    """Yield the progress callback of a run."""
    if not isinstance(progress, bool):
        yield progress
    elif not progress:
        yield None
    else:
        from tissuec.core.progress import RunProgress

        with RunProgress(name, duration, shown=True, anywhere=True) as line:
            yield line.at


def _judged(path: Path, outcome: "Outcome", *, strict: bool, temporary: bool) -> "Trajectory":
    """Return a result; what is wrong with it is an error or a warning."""
    from tissuec.api.notebook import Trajectory

    trajectory = Trajectory.temporary(path) if temporary else Trajectory(path)
    try:
        for complaint in _complaints(outcome, trajectory):
            if strict:
                raise complaint
            _warn(str(complaint))
    except BaseException:
        # Nobody gets it; and HDF5 does not see what a resumed run writes to an open file.
        trajectory.close()
        raise
    return trajectory


def _complaints(outcome: "Outcome", trajectory: "Trajectory") -> Iterator[TissueError]:
    """Yield an error for each deviation from what the scene expects.

    Raises:
        KeyboardInterrupt, SystemExit: The run or its companion was interrupted.
    """
    from tissuec.core.signals import exit_code

    if outcome.kind == "interrupted" or outcome.signal is not None:
        if outcome.signal in (None, signal.SIGINT):
            raise KeyboardInterrupt(outcome.message)
        raise SystemExit(exit_code(outcome.signal))
    name = trajectory.scene
    if outcome.kind != "done":
        yield SimulationError(f"{name}: {outcome.message}")
    promise = trajectory.promise
    if promise.state in ("broken", "unknown"):
        yield SimulationError(f"{name}: {promise.sentence}")
    for doubt in trajectory.doubts:
        yield SimulationError(f"{name}: {doubt}")
    for judged in trajectory.expectations:
        if judged.state == "fails" or (judged.state == "not reached" and trajectory.finished):
            failure = judged.failure
            yield ExpectationError(f"{failure.expectation}\n  failed {failure.measured}")
        if judged.undecided:
            yield SimulationError(f"{judged.failure.expectation}: {judged.undecided}")


def _warn(*messages: str) -> None:
    """Warn the caller of the public function that a message is about."""
    if not messages:
        return
    from inspect import currentframe

    frame, depth = currentframe(), 1
    # The globals of code in exec() may have no name.
    while frame is not None and str(frame.f_globals.get("__name__")).startswith("tissuec."):
        frame, depth = frame.f_back, depth + 1
    for message in messages:
        warnings.warn(message, TissueWarning, stacklevel=depth)
