"""The whole of tissuec on one page: text -> Module -> Scene -> Network and Plan -> Outcome.

Each stage is one function of immutable values, so that any of them can be shown or tested:

    source  = read_source(path)                the text
    program = load(source, libraries, …)       syntax nodes, imports included
    scene   = resolve(program, …)              names bound, SI numbers
    compiled = compile_scene(scene, …)         arrays and a plan
    outcome = simulate(compiled, path, …)      motion, in one HDF5 file
"""

import os
import pickle
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import Struct, field

from tissuec.compiler.checks import check_all
from tissuec.compiler.compile import Compiled, compile_scene
from tissuec.compiler.profiles import table_texts
from tissuec.core.data import as_data
from tissuec.core.errors import CompileError, Diagnostic
from tissuec.core.source import Source
from tissuec.engine.integrators.procedures import stated
from tissuec.scene.findings import Findings
from tissuec.scene.imports import DISK, Files, Program, load, read_source
from tissuec.scene.learning import refuse_without_scene
from tissuec.scene.resolve import ResolvedProgram, resolve, resolve_words
from tissuec.script.plan import Plan

if TYPE_CHECKING:
    from tissuec.engine.execution.companion import Companion, ErrorEstimate, Launch, Mode
    from tissuec.engine.execution.run import Outcome


JOB = "job.pickle"  # in the folder of a companion run


class Request(Struct, frozen=True):
    """A request to compile a scene.

    Attributes:
        source: The text of the scene.
        overrides: Texts of ``--set``, such as "cut time=0.9 s".
        libraries: Folders of ``--library``.
        strict: Whether warnings count as errors.
        files: How the files that the scene uses are read.
    """

    source: Source
    overrides: tuple[str, ...] = ()
    libraries: tuple[Path, ...] = ()
    strict: bool = False
    files: Files = DISK

    @classmethod
    def file(
        cls,
        path: Path,
        *,
        overrides: Sequence[str] = (),
        libraries: Sequence[Path] = (),
        strict: bool = False,
    ) -> "Request":
        """Return a request for a file.

        Args:
            path: The file.
            overrides: Texts of ``--set``.
            libraries: Folders of ``--library``.
            strict: Whether warnings count as errors.

        Raises:
            CompileError: The file cannot be read.
        """
        return cls(read_source(path), tuple(overrides), tuple(libraries), strict)


def read_words(request: Request) -> tuple[ResolvedProgram, tuple[Diagnostic, ...]]:
    """Return vocabulary and tissues of a file that need not be a scene, and its warnings."""
    findings = Findings()
    program = _loaded(request, findings)
    words = resolve_words(program, findings, request.overrides)
    words.constants.evaluate_all()
    findings.raise_errors()
    return words, tuple(findings.warnings)


def compile_request(request: Request) -> tuple[Compiled, tuple[Diagnostic, ...]]:
    """Return a scene in arrays, and its warnings.

    Raises:
        CompileError: The text is wrong, or ``strict`` and there is a warning.
    """
    findings = Findings()
    program = _loaded(request, findings)
    return _compile(program, request, findings, thorough=False)


def check_request(
    request: Request, *, thorough: bool = True
) -> tuple[Compiled | None, tuple[Diagnostic, ...]]:
    """Return like ``compile_request``, looking closer; a file without bodies is no scene.

    Args:
        thorough: Whether to make also those checks that take time.
    """
    findings = Findings()
    program = _loaded(request, findings)
    if program.is_scene:
        return _compile(program, request, findings, thorough=thorough)
    words, warnings = read_words(request)
    refuse_without_scene(words.declarations, findings)
    findings.raise_errors()
    return None, warnings


def _loaded(request: Request, findings: Findings) -> Program:
    return load(request.source, request.libraries, findings, request.files)


def _compile(
    program: Program, request: Request, findings: Findings, *, thorough: bool
) -> tuple[Compiled, tuple[Diagnostic, ...]]:
    compiled = compile_scene(resolve(program, findings, request.overrides), findings)
    warnings = (*findings.warnings, *check_all(compiled, thorough=thorough))
    if request.strict and warnings:
        raise CompileError(warnings)
    return compiled, warnings


class Result(Struct, frozen=True):
    """Outcome of a run and its files.

    Attributes:
        path: The result file.
        estimate: How far the companion run was from the run, and what that says.
        views: Files beside a finished result that show ParaView its smooth surfaces, by body.
    """

    outcome: "Outcome"
    path: Path
    estimate: "ErrorEstimate | None" = None
    views: Mapping[str, Path] = field(default_factory=dict)


def simulate(
    compiled: Compiled,
    path: Path,
    *,
    request: Request,
    resume: bool = False,
    companion: "Mode" = "auto",
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> Result:
    """Run a compiled scene and write its result to ``path``.

    Args:
        compiled: The compiled scene.
        path: The result file.
        request: What the scene was compiled from.
        resume: Continue from the checkpoint of an interrupted run of the same text.
        companion: How the error is estimated by a run with finer steps: in a "process" beside
            the run, "inline" after it, by the better of both ("auto"), or not at all ("off").
        threads: Maximum number of threads for a large net; None for as many as processors, or
            half as many if the companion may use the others. Positions do not depend on it.
        progress: Called with the simulated time [s] now and then.

    Raises:
        PlaceError: The file cannot be written there, or there is nothing to resume.
        ResultError: Writing failed later on.
    """
    from tissuec.engine.execution.companion import Companion, threads_beside
    from tissuec.engine.execution.recorder import Recorder, wishes
    from tissuec.engine.execution.run import run
    from tissuec.engine.execution.signals import asked_to_stop
    from tissuec.results.resuming import find_checkpoint
    from tissuec.results.writer import ResultWriter

    manifest, state = manifest_of(compiled, request), None
    network, plan, text = compiled.network, compiled.plan, compiled.scene.source.text
    threads = threads or threads_beside(companion)
    beside = Companion(network, plan, companion, _launcher(request, threads), threads)
    # Signals wait until the file is closed; HDF5 cannot be interrupted.
    with asked_to_stop() as stop, beside:
        if resume:
            checkpoint = find_checkpoint(path, text, manifest, network)
            writer, state = ResultWriter.resume(path, checkpoint), checkpoint.state
        else:
            groups = tuple(compiled.named_groups())
            writer = ResultWriter(path, network, wishes(network, plan), manifest, text, groups)
        with writer:
            recorder = Recorder(network, plan, writer, tap=beside.take)
            asked = {"progress": _both(progress, beside), "interrupt": stop, "threads": threads}
            outcome = run(network, plan, recorder, resume=state, **asked)
            finished = outcome.kind == "done"
            estimate = beside.estimate(stop) if finished else None
            if estimate is not None and len(estimate.times):
                writer.companion(estimate.times, estimate.apart[:, None])
            facts = _facts(plan, outcome, estimate)
            written = writer.close(outcome.message, finished, facts)
            views = writer.views
    return Result(outcome, written, estimate, views)


def _both(
    progress: Callable[[float], None] | None, beside: "Companion"
) -> Callable[[float], None]:
    """Return what is told the simulated time: the caller's, and the companion run."""

    def tell(time: float) -> None:
        beside.tick(time)
        if progress is not None:
            progress(time)

    return tell


def _launcher(request: Request, threads: int) -> "Launch":
    """Return what gives the command that steps the companion of a request into a folder."""

    def launch(folder: Path) -> list[str]:
        (folder / JOB).write_bytes(pickle.dumps((request, threads)))
        return [sys.executable, "-m", "tissuec", "companion", str(folder)]

    return launch


def step_companion(folder: Path) -> None:
    """Step the companion run that a folder asks for, and leave its positions there."""
    import numpy as np

    from tissuec.engine.execution.companion import FINER, ROWS, TIMES, stepped

    parent = os.getppid()
    request, threads = pickle.loads((folder / JOB).read_bytes())
    compiled, _ = compile_request(request)
    times, rows = np.load(folder / TIMES), np.load(folder / ROWS, mmap_mode="r+")
    stepped(
        compiled.network, compiled.plan, times, FINER,
        rows=rows, interrupt=lambda: os.getppid() != parent, threads=threads,
    )  # fmt: skip
    if os.getppid() != parent:  # the run was killed, and nobody else removes its folder
        shutil.rmtree(folder, ignore_errors=True)


def _facts(
    plan: Plan, outcome: "Outcome", estimate: "ErrorEstimate | None"
) -> Mapping[str, Any]:
    """Return what a result says of how the run went."""
    facts = {
        "kind": outcome.kind,
        "method": outcome.statistics.method,
        "statistics": as_data(outcome.statistics),
        "notes": list(outcome.notes),
        "expectations": list(_judged(plan, outcome)),
        "failed_expectations": len(outcome.failures),
        "unreached_expectations": len(outcome.unreached),
    }
    return facts if estimate is None else facts | {"promise": estimate.as_dict()}


def _judged(plan: Plan, outcome: "Outcome") -> Iterator[Mapping[str, Any]]:
    """Yield whether each expectation holds, with the time and the numbers that tell."""
    failures = {failure.expectation: failure for failure in outcome.failures}
    for number, expectation in enumerate(plan.expectations):
        state, time, measured = "holds", *outcome.held.get(number, (None, ""))
        if number in failures:
            state, time = "fails", failures[number].time
            measured = failures[number].measured
        elif number in outcome.unreached:
            state = "not reached"
        span = expectation.span
        yield {
            "expect": span.one_line, "place": span.place, "state": state,
            "time": time, "measured": measured,
        }  # fmt: skip


def digests(compiled: Compiled) -> Mapping[str, str]:
    """Return the SHA-256 digests of mesh files, by the names that the scene has for them."""
    meshes = (placed.drawing.mesh for placed in compiled.groups.bodies.values())
    origins = (mesh.origin for mesh in meshes if mesh.origin is not None)
    return {origin.file.name: origin.digest for origin in origins}


def _sources(compiled: Compiled) -> Mapping[str, str]:
    """Return the texts beside the scene that it is made of: what it uses, and its tables."""
    declarations = compiled.scene.declarations
    script = declarations.single.get("script")
    tables = table_texts(script.items, declarations.library) if script is not None else {}
    return {source.name: source.text for source in compiled.scene.imports} | tables


def manifest_of(compiled: Compiled, request: Request) -> Mapping[str, Any]:
    """Return the facts of a result about its origin: text, settings and plan."""
    from tissuec.compiler.prediction import skipped

    simulation = compiled.plan.simulation
    return {
        "scene": request.source.name,
        "about": compiled.scene.about,
        "sources": _sources(compiled),
        "files": digests(compiled),
        "overrides": list(request.overrides),
        "libraries": [str(folder) for folder in request.libraries],
        "integrator": simulation.integrator,
        "tolerance": simulation.tolerance,
        "step": simulation.step,
        "choices": stated(simulation.choices, defaults=False) or None,
        "duration": simulation.duration,
        "plan": {"skipped": list(skipped(compiled))},
    }
