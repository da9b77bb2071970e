"""The stages from a text to a result, one function each.

    Request ── read_words ──────> ResolvedProgram     vocabulary and tissues of any file
       │
       ├── compile_request ─────> Compiled, warnings  load, resolve, compile_scene, check_all
       ├── check_request ───────> the same, with checks that take longer
       │
    Compiled ── simulate ───────> Result              run, estimate the error, write a file

``validate.validation`` compares a run with SciPy, and ``learn.fit.learning`` fits parameters to
data; both start from ``Compiled``.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec import Struct, field
from msgspec.structs import replace

from tissuec.compiler.checks import check_all
from tissuec.compiler.compile import Compiled, compile_scene
from tissuec.compiler.manifest import manifest_of, outcome_facts
from tissuec.core.errors import CompileError, Diagnostic
from tissuec.scene.findings import Findings
from tissuec.scene.imports import Program, load
from tissuec.scene.learning import refuse_without_scene
from tissuec.scene.request import Request
from tissuec.scene.resolve import ResolvedProgram, resolve, resolve_words

if TYPE_CHECKING:
    from tissuec.engine.execution.companion import ErrorEstimate, Mode
    from tissuec.engine.execution.run import Outcome


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
    return compile_program(program, request, findings)


def check_request(
    request: Request, *, thorough: bool = True, levels: bool = True
) -> tuple[Compiled | None, tuple[Diagnostic, ...]]:
    """Return like ``compile_request``, looking closer; a file without bodies is no scene.

    Args:
        request: What to check.
        thorough: Whether to make also those checks of the net that take time.
        levels: Whether to try the values of studies.
    """
    findings = Findings()
    program = _loaded(request, findings)
    if program.is_scene:
        return compile_program(program, request, findings, thorough=thorough, levels=levels)
    words, warnings = read_words(request)
    refuse_without_scene(words.declarations, findings)
    findings.raise_errors()
    return None, warnings


def _loaded(request: Request, findings: Findings) -> Program:
    return load(request.source, request.libraries, findings, request.files)


def compile_program(
    program: Program,
    request: Request,
    findings: Findings,
    *,
    thorough: bool = False,
    levels: bool = False,
) -> tuple[Compiled, tuple[Diagnostic, ...]]:
    """Return a scene in arrays from its texts, and its warnings.

    Args:
        program: The texts of the scene.
        request: What was asked for.
        findings: Takes diagnostics.
        thorough: Whether to make also those checks of the net that take time.
        levels: Whether to try the values of studies.

    Raises:
        CompileError: The text is wrong, or ``strict`` and there is a warning.
    """
    compiled = compile_scene(resolve(program, findings, request.overrides), findings)
    if compiled.scene.studies:
        from tissuec.compiler.studies import check_studies  # where there are any

        check_studies(compiled, program, request.overrides, levels=levels)
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
    views: Mapping[str, Path] = field(default_factory=dict[str, Path])


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
    from tissuec.engine.execution.companion import Companion, launcher, threads_beside
    from tissuec.engine.execution.recorder import Recorder, wishes
    from tissuec.engine.execution.run import run
    from tissuec.engine.execution.signals import asked_to_stop
    from tissuec.results.resuming import find_checkpoint
    from tissuec.results.writer import ResultWriter

    manifest, state = manifest_of(compiled, request), None
    network, plan, text = compiled.network, compiled.plan, compiled.scene.source.text
    threads = threads or threads_beside(companion)
    beside = Companion(network, plan, companion, launcher((request, threads)), threads)
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
            outcome = run(
                network, plan, recorder, progress=progress, watch=beside.tick, interrupt=stop,
                resume=state, threads=threads,
            )  # fmt: skip
            outcome = replace(outcome, wall_time=writer.stop_clock())
            is_done, estimate = outcome.kind == "done", None
            if is_done:
                estimate = beside.estimate(outcome.statistics, stop)
                writer.companion(estimate.times, estimate.apart[:, None])
            facts = outcome_facts(plan, outcome, estimate)
            written, views = writer.close(outcome.message, is_done, facts), writer.views
    return Result(replace(outcome, signal=stop.signal), written, estimate, views)
