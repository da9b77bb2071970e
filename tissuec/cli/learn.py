"""``tissuec learn``: Fit parameters or words of a scene to measured data."""

import shlex
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

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
    keep_input,
    print_json,
    report,
    scene_options,
    tell_mistakes,
    worker_options,
)  # fmt: skip
from tissuec.cli.learn_options import LearnOptions
from tissuec.core.errors import CompileError, counted
from tissuec.core.hints import did_you_mean
from tissuec.engine.execution.signals import SIGNALLED, exit_code
from tissuec.results import wording

if TYPE_CHECKING:
    from tissuec.compiler.compile import Compiled
    from tissuec.learn.fit.outcome import Learnt
    from tissuec.scene.learn_model import VocabularyFit
    from tissuec.scene.request import Request
    from tissuec.script.fit_problem import FitProblem
    from tissuec.workers.workers import Workers

GRADIENT = 1e-6  # relative difference from which on an exact derivative is wrong
KEPT = ".learning"  # behind the name of a preset: what goes on after an interruption


@click.command(cls=Command)
@click.argument("scene", type=click.Path(path_type=Path))
@click.argument("name", required=False)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Preset to write instead of the one in the block (one block only).",
)
@click.option(
    "--fresh", is_flag=True, help="Discard the state of an interrupted fit and start again."
)
@click.option("--anyway", is_flag=True, help="Write the preset even if the fit failed.")
@click.option(
    "--force", is_flag=True, help="Overwrite files that were not written by learning."
)
@click.option(
    "--check-gradient",
    "gradient",
    is_flag=True,
    help="Do not fit; compare exact derivatives with finite differences.",
)
@click.option("--diff", is_flag=True, help="Print the changes of vocabularies as a diff.")
@worker_options
@scene_options
def command(
    settings: Settings,
    scene: Path,
    name: str | None,
    overrides: tuple[str, ...],
    libraries: tuple[Path, ...],
    strict: bool,
    workers: int | None,
    scheduler: str | None,
    **options: Any,
) -> int:
    """Fit parameters or words of SCENE to measured data, as its learn blocks specify.

    A block can also fit the words and rules of a vocabulary to the numbers of tissues; then
    SCENE need not be a scene. NAME selects one block; without it, all blocks are fitted in
    order. The results are printed with confidence intervals and written as a preset, which any
    scene can use. After an interruption, the same command resumes. Exit code: 0 done; 1 the fit
    failed, and no preset is written unless with --anyway: an expectation failed, the passes ran
    out, the data does not identify all parameters, or the error is too large (with --strict,
    also if a note doubts the result); 2 the text or the data is wrong; 3 the motion could not
    be computed; 130 interrupted.
    """
    from tissuec.cli.learn_words import fit_vocabulary
    from tissuec.pipeline import read_fittable
    from tissuec.scene.learn_model import VocabularyFit
    from tissuec.scene.request import Request
    from tissuec.workers.selection import workers_of

    request = Request.file(scene, overrides=overrides, libraries=libraries, strict=strict)
    try:
        program, warnings = read_fittable(request)
    except CompileError as error:
        tell_mistakes(error, settings, scene=str(scene))
        return WRONG_TEXT
    if not settings.json:
        report(warnings, settings)
    fit_problems = _chosen(program.blocks, name, scene)
    if options["output"] is not None and len(fit_problems) > 1:
        raise click.UsageError("-o is for one learn block; give its name, too")
    again = _again(scene, name, wording.set_options(overrides, libraries), strict, options)
    wishes = LearnOptions(again=again, **options)
    codes: list[int] = []
    documents: list[dict[str, Any]] = []
    with workers_of(workers, scheduler) as crew:
        for fit_problem in fit_problems:
            if isinstance(fit_problem, VocabularyFit):
                fitted = partial(fit_vocabulary, fit_problem, request, wishes, settings)
            else:
                assert program.compiled is not None
                task = _Task(program.compiled, fit_problem, request, crew)
                fitted = partial(_fit_data, task, wishes, settings)
            code, document = _carry_out(fitted, wishes, settings)
            codes.append(code)
            facts = {"scene": str(scene), "learn": fit_problem.name, "ok": code == DONE}
            documents.append(facts | {"diagnostics": as_json(warnings)} | document)
            if code > SIGNALLED:
                break
    if settings.json:
        print_json(documents[0] if len(fit_problems) == 1 else documents)
    return max(codes)


def _chosen(
    fit_problems: "Sequence[FitProblem | VocabularyFit]", name: str | None, scene: Path
) -> "Sequence[FitProblem | VocabularyFit]":
    """Return the learn blocks that are meant."""
    from tissuec.core.names import key_of

    if not fit_problems:
        raise click.UsageError(f'"{scene}" has no learn block')
    if name is None:
        return fit_problems
    found = [
        fit_problem for fit_problem in fit_problems if key_of(fit_problem.name) == key_of(name)
    ]
    if not found:
        names = [fit_problem.name for fit_problem in fit_problems]
        hint = did_you_mean(name, names) or f"there are: {', '.join(names)}"
        raise click.UsageError(f'"{scene}" has no learn block called "{name}"; {hint}')
    return found


def _again(
    scene: Path,
    name: str | None,
    given: Sequence[tuple[str, Any]],
    strict: bool,
    options: dict[str, Any],
) -> list[str]:
    """Return the words of the command line that goes on with a learning."""
    words = ["tissuec", "learn", str(scene), *([] if name is None else [name])]
    if options["output"] is not None:
        words += ["-o", str(options["output"])]
    words += [f"--{flag}" for flag in ("anyway", "force", "diff") if options[flag]]
    words += [str(word) for pair in given for word in pair]
    return [*words, *(["--strict"] if strict else [])]


class _Task(NamedTuple):
    """What is learnt, and who helps."""

    compiled: "Compiled"
    fit_problem: "FitProblem"
    request: "Request"
    workers: "Workers"


def _fit_data(
    task: _Task, wishes: LearnOptions, settings: Settings
) -> tuple[int, dict[str, Any]]:
    """Fit one block to its data, or check its derivatives."""
    if wishes.gradient:
        return _check_gradient(task, settings)
    return _learn(task, wishes, settings)


def _carry_out(
    fitted: Callable[[], tuple[int, dict[str, Any]]], wishes: LearnOptions, settings: Settings
) -> tuple[int, dict[str, Any]]:
    """Carry out one block; returns the exit code and the document."""
    from tissuec.learn.fit.learning import Unlearnable

    try:
        return fitted()
    except CompileError as error:
        if not settings.json:
            report(error.diagnostics, settings)
        return WRONG_TEXT, {"diagnostics": as_json(error.diagnostics)}
    except Unlearnable as error:
        if not settings.json:
            echo(f"error: {error}", err=True)
        return STOPPED, {"error": str(error)}
    except KeyboardInterrupt as error:
        again = shlex.join(wishes.again)
        if not settings.json:
            echo("interrupted", err=True)
            settings.say(f"  resume with: {again}")
        return exit_code(getattr(error, "signal", None)), {
            "error": "interrupted",
            "again": again,
        }


# --- learning ---------------------------------------------------------------------------------


def _learn(task: _Task, wishes: LearnOptions, settings: Settings) -> tuple[int, dict[str, Any]]:
    from tissuec.learn.fit.learning import learn, rehearsal
    from tissuec.learn.fit.session import prepare
    from tissuec.learn.presets.placing import refuse_others
    from tissuec.learn.presets.preset import compose
    from tissuec.learn.report.data import as_dict
    from tissuec.learn.report.passes import Passes
    from tissuec.learn.report.words import differences, drifts

    compiled, fit_problem, request, workers = task
    target = wishes.output or fit_problem.write
    if target is not None:
        _keep_others(target, compiled, force=wishes.force)
    session = prepare(compiled, fit_problem, request)
    if target is not None:
        planned = compose(rehearsal(session), compiled, request, target)
        if not wishes.force:
            refuse_others(planned.files)
    state = _state(target, fit_problem, request)
    state.parent.mkdir(parents=True, exist_ok=True)
    if state.exists() and not wishes.fresh and not settings.json:
        settings.say(
            f"resumes from {state} if texts and data are unchanged (--fresh starts again)"
        )
    shown = settings.shows_progress
    with Passes(f"learn {fit_problem.name}", shown=shown) as line:
        learnt = learn(
            compiled, fit_problem, request, session=session, state=state, fresh=wishes.fresh,
            progress=line.at, workers=workers,
        )  # fmt: skip
    scene = compiled.scene
    moved = drifts(scene, learnt.words)
    document = as_dict(learnt, moved)
    if not settings.json:
        _tell(learnt, moved, settings)
        if wishes.diff:
            click.echo("".join(differences(scene, learnt.words)), nl=False)
    doubt = _doubt(learnt, strict=request.strict)
    may_write = wishes.anyway or not doubt
    document["written"] = _write(
        learnt, compiled, request, target if may_write else None, wishes, settings
    )
    if may_write:
        state.unlink(missing_ok=True)
    # What the data leaves open is no failure for those who want it anyway.
    fine = may_write and not _doubt(learnt, identified=True)
    if doubt and not fine and not settings.json:
        is_lost = target is not None and not may_write
        lost = "; no preset is written (to write it: --anyway)" if is_lost else ""
        echo(f"FAILED: {doubt}{lost}", err=True)
    return DONE if fine else FAILED, document


def _doubt(learnt: "Learnt", *, strict: bool = False, identified: bool = False) -> str:
    """Return why what was learnt should not be used, empty if it can be.

    Args:
        learnt: What was learnt.
        strict: Whether what a note doubts is a failure.
        identified: Whether to take parameters as identified.
    """
    from tissuec.learn.fit.expectations import judged
    from tissuec.learn.report.data import is_identified

    if learnt.failure:
        return learnt.failure
    if not identified and not is_identified(learnt):
        return "the data does not identify all parameters"
    if strict and learnt.doubts:
        return learnt.doubts[0]
    if not learnt.converged:
        return f"{learnt.reason}; increase passes, or start closer to the solution"
    failed = sum(not verdict.holds for verdict in judged(learnt))
    return f"{counted(failed, 'expectation')} failed" if failed else ""


def _keep_others(target: Path, compiled: "Compiled", *, force: bool) -> None:
    """Refuse to lose a text of the scene, or another file, before time is spent."""
    from tissuec.learn.presets.placing import refuse_others

    for source in (*compiled.scene.imports, compiled.scene.source):
        if source.path is not None:
            keep_input(target, source.path)
    if not force:
        refuse_others([target])


def _state(target: Path | None, fit_problem: "FitProblem", request: "Request") -> Path:
    """Return where passes are kept: beside the preset, or in the current directory."""
    if target is not None:
        return target.with_name(target.name + KEPT)
    stem = Path(request.source.name).stem
    return Path(f"{stem}.{'_'.join(fit_problem.name.split())}{KEPT}")


def _write(
    learnt: "Learnt",
    compiled: "Compiled",
    request: "Request",
    target: Path | None,
    wishes: LearnOptions,
    settings: Settings,
) -> list[str]:
    """Write the preset, if it goes anywhere; returns the names of the files."""
    if target is None:
        return []
    from tissuec.learn.presets.placing import place
    from tissuec.learn.presets.preset import compose

    files = place(compose(learnt, compiled, request, target), force=wishes.force)
    for file in files if not settings.json else ():
        settings.say(f"wrote {file}")
    return [str(file) for file in files]


def _tell(learnt: "Learnt", moved: Any, settings: Settings) -> None:
    """Say what came out, and which expectations fail."""
    from tissuec.learn.fit.expectations import judged
    from tissuec.learn.report.text import as_text

    echo("\n".join(as_text(learnt, moved)))
    verdicts = judged(learnt)
    for demand, holds, measured in verdicts:
        if not holds:
            echo(f"FAILED {demand.span.place}: {demand.span.one_line}", err=True)
            echo(f"       {measured}", err=True)
    if verdicts:
        states = ["holds" if verdict.holds else "fails" for verdict in verdicts]
        settings.say(f"expectations: {wording.expectations(states)}")


# --- derivatives ------------------------------------------------------------------------------


def _check_gradient(task: _Task, settings: Settings) -> tuple[int, dict[str, Any]]:
    """Tell how far exact derivatives are from differences; FAILED if too far."""
    from tissuec.learn.fit.gradient_check import check_gradient
    from tissuec.learn.report.gradient import as_lines, is_good

    compiled, fit_problem, request, _ = task
    found = check_gradient(compiled, fit_problem, request)
    worst = max((row.apart for row in found), default=0.0)
    code = DONE if is_good(found, GRADIENT) else FAILED
    if not settings.json:
        echo("\n".join(as_lines(fit_problem.name, found, GRADIENT)))
    return code, {"gradient": [row._asdict() for row in found], "worst": worst}
