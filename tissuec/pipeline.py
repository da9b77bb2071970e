"""The stages from a text to a result, one function each.

    Request ── read_words ──────> ResolvedProgram     vocabulary and tissues of any file
       │
       ├── compile_request ─────> Compiled, warnings  load, resolve, compile_scene, check_all
       ├── check_request ───────> the same, with checks that take longer
       │
    Compiled ── simulate ───────> Result              run, estimate the error, write a file

``validate.validation`` compares a run with SciPy, ``learn.fit.learning`` fits parameters to
data, and ``studies.study`` runs a scene many times; all start from ``Compiled``. What is found
becomes a ``core.report.Report``, of a run in ``view.run_summary``; ``cli.common`` prints it.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import Struct, field

from tissuec.compiler.checks import check_all
from tissuec.compiler.compile import Compiled, compile_scene
from tissuec.compiler.expectations import split_expectations
from tissuec.compiler.manifest import manifest_of, outcome_facts
from tissuec.core.errors import CompileError, Diagnostic, in_order_of_text
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.scene.program.imports import Program, load
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.reading.findings import Findings
from tissuec.scene.request import Request
from tissuec.scene.resolve import resolve, resolve_words
from tissuec.script.fit_problem import Data, FitProblem

if TYPE_CHECKING:
    from tissuec.engine.execution.companion import ErrorEstimate, Mode
    from tissuec.engine.execution.run import Outcome
    from tissuec.measurements.experiment import Experiment
    from tissuec.results.writer import ResultWriter
    from tissuec.scene.learning.model import VocabularyFit


def read_words(request: Request) -> tuple[ResolvedProgram, tuple[Diagnostic, ...]]:
    """Return vocabulary and tissues of a file that need not be a scene, and its warnings."""
    findings = Findings()
    program = _loaded(request, findings)
    words = resolve_words(program, findings, request.overrides)
    words.constants.evaluate_all()
    findings.raise_errors()
    return words, tuple(findings.warnings)


def compile_request(
    request: Request, *, halvings: int = 0
) -> tuple[Compiled, tuple[Diagnostic, ...]]:
    """Return a scene in arrays, and its warnings.

    Args:
        halvings: How often the cells of bodies of elements are halved.

    Raises:
        CompileError: The text is wrong, or ``strict`` and there is a warning.
    """
    findings = Findings()
    program = _loaded(request, findings)
    return compile_program(program, request, findings, halvings=halvings)


def ignored(_: Findings) -> None:
    """Do nothing with findings."""


def check_request(
    request: Request,
    *,
    thorough: bool = True,
    levels: bool = True,
    resolved: Callable[[Findings], None] = ignored,
) -> tuple[Compiled | None, tuple[Diagnostic, ...]]:
    """Check a request, with further checks; a file without bodies yields no ``Compiled``.

    Args:
        request: What to check.
        thorough: Whether to run the slow checks of the net as well.
        levels: Whether to try the values of studies, and to read the data of learn blocks.
        resolved: Called with the findings so far once all names are resolved.
    """
    findings = Findings()
    program = _loaded(request, findings)
    if program.is_scene:
        return compile_program(
            program, request, findings, thorough=thorough, levels=levels, resolved=resolved
        )
    from tissuec.scene.learning.block import refuse_without_scene  # a preset

    words, warnings = read_words(request)
    refuse_without_scene(words.declarations, findings)
    findings.raise_errors()
    if words.declarations.of("learn"):
        read_vocabulary_fits(request)
    return None, warnings


class FittableProgram(Struct, frozen=True, eq=False):
    """A text with learn blocks.

    Attributes:
        compiled: The scene; None for a text that is not a scene.
        blocks: In the order of the text.
    """

    compiled: Compiled | None
    blocks: "tuple[FitProblem | VocabularyFit, ...]"


def read_fittable(request: Request) -> tuple[FittableProgram, tuple[Diagnostic, ...]]:
    """Return a text with its learn blocks, and its warnings.

    A text whose learn blocks fit only words need not be a scene.

    Raises:
        CompileError: The text is wrong, or ``strict`` and there is a warning.
    """
    findings = Findings()
    program = _loaded(request, findings)
    if not program.is_scene:
        fits, warnings = read_vocabulary_fits(request)
        if fits:
            return FittableProgram(None, fits), warnings
    compiled, warnings = compile_program(program, request, findings)
    blocks = {
        key_of(one.name): one for one in (*compiled.fit_problems, *compiled.vocabulary_fits)
    }
    order = compiled.scene.declarations.of("learn")
    return FittableProgram(compiled, tuple(blocks[key] for key in order)), warnings


def read_vocabulary_fits(
    request: Request,
) -> "tuple[tuple[VocabularyFit, ...], tuple[Diagnostic, ...]]":
    """Return the learn blocks of a text that is not a scene, and its warnings.

    Raises:
        CompileError: The text is wrong, a learn block needs a scene, or ``strict`` and there
            is a warning.
    """
    from tissuec.compiler.learning.expectations import demands_of
    from tissuec.scene.learning.block import read_learn_blocks, refuse_without_scene
    from tissuec.scene.learning.model import VocabularyFit

    findings = Findings()
    program = _loaded(request, findings)
    words = resolve_words(program, findings, request.overrides)
    words.constants.evaluate_all()
    refuse_without_scene(words.declarations, findings)
    blocks = read_learn_blocks(words, tuple(module.source for module in program.modules))
    found = {key: one for key, one in blocks.items() if isinstance(one, VocabularyFit)}
    _, of_learning = split_expectations(words.declarations.expects)
    demands = demands_of(words.constants, found, of_learning) if found else {}
    findings.raise_errors()
    if request.strict and findings.warnings:
        raise CompileError(findings.warnings)
    fits = (replace(one, demands=tuple(demands[key])) for key, one in found.items())
    return tuple(fits), tuple(findings.warnings)


def _loaded(request: Request, findings: Findings) -> Program:
    return load(request.source, request.libraries, findings, request.files)


def compile_program(
    program: Program,
    request: Request,
    findings: Findings,
    *,
    thorough: bool = False,
    levels: bool = False,
    halvings: int = 0,
    resolved: Callable[[Findings], None] = ignored,
) -> tuple[Compiled, tuple[Diagnostic, ...]]:
    """Return a scene in arrays from its texts, and its warnings.

    Args:
        program: The texts of the scene.
        request: The request of the run.
        findings: Takes diagnostics.
        thorough: Whether to run the slow checks of the net as well.
        levels: Whether to try the values of studies, and to read the data of learn blocks.
        halvings: How often the cells of bodies of elements are halved.
        resolved: Called with the findings so far once all names are resolved.

    Raises:
        CompileError: The text is wrong, or ``strict`` and there is a warning.
    """
    scene = resolve(program, findings, request.overrides)
    resolved(findings)
    if halvings:
        from tissuec.compiler.bodies.refined import refined

        scene = refined(scene, halvings, findings)
    compiled = compile_scene(scene, findings)
    if compiled.scene.studies:
        from tissuec.compiler.study.block import check_studies  # where there are any

        check_studies(compiled, program, request.overrides, levels=levels)
    if levels and compiled.fit_problems:
        _check_data(compiled, request)
    checked = check_all(compiled, thorough=thorough)
    warnings = tuple(in_order_of_text((*findings.warnings, *checked)))
    if request.strict and warnings:
        raise CompileError(warnings)
    return compiled, warnings


def _check_data(compiled: Compiled, request: Request) -> None:
    """Report what is wrong with the data of learn blocks, once at each place.

    Raises:
        CompileError: Data is wrong, or the scene is with the settings of an experiment.
    """
    from tissuec.measurements.reading import (  # where data is
        check_count,
        check_times,
        read_experiment,
    )

    library = compiled.scene.constants.library
    if library is not None and library.kept is not None:
        return  # the text of a result, which keeps no data
    found: dict[Span | None, Diagnostic] = {}
    for fit_problem in compiled.fit_problems:
        experiments: list[Experiment] = []
        for data in fit_problem.data:
            try:
                own, problem = set_for(compiled, fit_problem, data, request)
                experiment = read_experiment(data, problem, own.network)
                check_times(experiment, own.plan.simulation.duration)
                if problem.axis.nodes is not None:
                    from tissuec.compiler.learning.displacements import rows_of

                    rows_of(own, experiment.series, problem.axis)
                experiments.append(experiment)
            except CompileError as error:
                for one in error.diagnostics:
                    found.setdefault(one.span, one)
        if not found:
            try:
                check_count(experiments, fit_problem)
            except CompileError as error:
                found |= {one.span: one for one in error.diagnostics}
    findings = compiled.scene.constants.findings
    findings.extend(found.values())
    findings.raise_errors()


def set_for(
    compiled: Compiled, fit_problem: FitProblem, data: Data, request: Request
) -> tuple[Compiled, FitProblem]:
    """Return a scene and one of its learn blocks with the settings of one experiment.

    Args:
        compiled: The scene with the values in its text.
        fit_problem: The learn block.
        data: The experiment.
        request: What the scene was compiled from.

    Raises:
        CompileError: The scene is wrong with these settings.
    """
    if not data.overrides:
        return compiled, fit_problem
    own = replace(request, overrides=(*request.overrides, *data.overrides))
    compiled, _ = compile_request(own)
    return compiled, next(one for one in compiled.fit_problems if one.name == fit_problem.name)


class Result(Struct, frozen=True):
    """Outcome of a run and its files.

    Attributes:
        path: The result file.
        estimate: How far the companion run was from the run, and what that says.
        views: Files beside a finished result that show ParaView its smooth surfaces, by body.
        blocks: The blocks file beside a finished result, if one was requested.
        left_out: Sentences about what it does not contain.
    """

    outcome: "Outcome"
    path: Path
    estimate: "ErrorEstimate | None" = None
    views: Mapping[str, Path] = field(default_factory=dict[str, Path])
    blocks: Path | None = None
    left_out: tuple[str, ...] = ()


def simulate(
    compiled: Compiled,
    path: Path,
    *,
    request: Request,
    resume: bool = False,
    companion: "Mode" = "auto",
    threads: int | None = None,
    blocks: bool = False,
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
        blocks: Whether to write a blocks file, also if the output block has none.
        progress: Called with the simulated time [s] now and then.

    Raises:
        PlaceError: The file cannot be written there, there is nothing to resume, or there are
            no frames to make blocks of.
        ResultError: Writing failed later on.
    """
    from tissuec.core.signals import asked_to_stop
    from tissuec.engine.execution.companion import Companion, launcher, threads_beside
    from tissuec.engine.execution.recorder import Recorder
    from tissuec.engine.execution.run import run

    network, plan = compiled.network, compiled.plan
    if blocks := blocks or plan.output.blocks:
        _check_blocks(compiled, path)
    threads = threads or threads_beside(companion)
    beside = Companion(network, plan, companion, launcher((request, threads)), threads)
    # Signals wait until the file is closed; HDF5 cannot be interrupted.
    with asked_to_stop() as stop, beside:
        writer, state = _writer(compiled, path, request, resume=resume)
        with writer:
            recorder = Recorder(network, plan, writer, tap=beside.tap)
            outcome = run(
                network, plan, recorder, progress=progress, watch=beside.tick, interrupt=stop,
                resume=state, threads=threads,
            )  # fmt: skip
            outcome = replace(outcome, wall_time=writer.stop_clock())
            is_done, estimate = outcome.kind == "done", None
            if is_done:
                estimate = beside.estimate(outcome.statistics, stop, failures=outcome.failures)
                writer.companion(estimate.times, estimate.apart[:, None])
            facts = outcome_facts(plan, outcome, estimate)
            written, views = writer.close(outcome.message, is_done, facts), writer.views
        result = Result(outcome, written, estimate, views)
        if blocks and is_done:
            result = _with_blocks(compiled, result)
    return replace(result, outcome=replace(outcome, signal=stop.signal))


def _writer(
    compiled: Compiled, path: Path, request: Request, *, resume: bool
) -> "tuple[ResultWriter, Mapping[str, Any] | None]":
    """Return the writer of a result, and the state that a run resumes from."""
    from tissuec.engine.execution.recorder import wishes
    from tissuec.results.resuming import find_checkpoint
    from tissuec.results.writer import ResultWriter

    manifest, network = manifest_of(compiled, request), compiled.network
    text = compiled.scene.source.text
    if resume:
        checkpoint = find_checkpoint(path, text, manifest, network)
        return ResultWriter.resume(path, checkpoint), checkpoint.state
    recording, groups = wishes(network, compiled.plan), tuple(compiled.named_groups())
    return ResultWriter(path, network, recording, manifest, text, groups), None


def _check_blocks(compiled: Compiled, path: Path) -> None:
    """Check that blocks can be written; PlaceError."""
    from tissuec.results import PlaceError
    from tissuec.results.paraview import check_blocks

    if not len(compiled.plan.output.frames):
        raise PlaceError(
            f"{compiled.scene.source.name} records no trajectory to make blocks of; write "
            "output { trajectory every 10 ms }"
        )
    check_blocks(path)


def _with_blocks(compiled: Compiled, result: Result) -> Result:
    """Write a blocks file beside a finished result."""
    from tissuec.compiler.anatomy import anatomy_of
    from tissuec.core.signals import Halted
    from tissuec.results.blocks.file import write_blocks
    from tissuec.results.paraview import blocks_path
    from tissuec.results.trajectory import Trajectory

    path = blocks_path(result.path)
    try:
        with Trajectory.open(result.path) as trajectory:
            written = write_blocks(trajectory, anatomy_of(compiled), path, links=True)
    except Halted:
        how = f"tissuec export {result.path} --format blocks"
        return replace(result, left_out=(f"no blocks were written; to write them: {how}",))
    return replace(result, blocks=path, left_out=written.left_out)
