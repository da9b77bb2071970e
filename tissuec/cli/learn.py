"""``tissuec learn``: Fit parameters or words of a scene to measured data."""

import shlex
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from msgspec import Struct

from tissuec.cli.common import (
    Command,
    Reports,
    SceneOptions,
    Settings,
    keep_input,
    scene_options,
    worker_options,
)
from tissuec.core.errors import CompileError, counted
from tissuec.core.hints import did_you_mean
from tissuec.core.report import (
    DONE,
    FAILED,
    STOPPED,
    WRONG_TEXT,
    Fact,
    Part,
    Report,
    Verbatim,
    failed,
)
from tissuec.core.signals import exit_code
from tissuec.core.structs import replace

if TYPE_CHECKING:
    from tissuec.compiler.compile import Compiled
    from tissuec.core.source import Source
    from tissuec.core.workers.workers import Workers
    from tissuec.learn.fit.outcome import DemandVerdict, Learnt
    from tissuec.scene.learning.model import VocabularyFit
    from tissuec.scene.request import Request
    from tissuec.script.fit_problem import FitProblem

GRADIENT = 1e-6  # relative difference from which on an exact derivative is wrong
KEPT = ".learning"  # after the name of a preset: the state of an interrupted fit


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
    given: SceneOptions,
    workers: int | None,
    scheduler: str | None,
    **options: Any,
) -> Reports:
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
    from tissuec.pipeline import read_fittable

    request = given.request(scene)
    program, warnings = read_fittable(request)
    diagnostics = settings.warn(warnings)
    blocks = _chosen(program.blocks, name, scene)
    if options["output"] is not None and len(blocks) > 1:
        raise click.UsageError("-o is for one learn block; give its name, too")
    again = _again(scene, name, given, options)
    order = _FitOrder(again=again, **options)

    def each() -> Iterator[Report]:
        from tissuec.core.workers.selection import workers_of

        with workers_of(workers, scheduler) as crew:
            for block in blocks:
                task = _Task(program.compiled, block, request, crew, order, settings)
                report = task.report()
                facts = {"scene": str(scene), "learn": block.name, "diagnostics": diagnostics}
                yield replace(report, document=facts | report.document)

    return Reports(each(), len(blocks) > 1)


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
    scene: Path, name: str | None, given: SceneOptions, options: dict[str, Any]
) -> list[str]:
    """Return the words of the command line that resumes a learning."""
    from tissuec.scene.request import set_options

    words = ["tissuec", "learn", str(scene), *([] if name is None else [name])]
    if options["output"] is not None:
        words += ["-o", str(options["output"])]
    words += [f"--{flag}" for flag in ("anyway", "force", "diff") if options[flag]]
    pairs = set_options(given.overrides, given.libraries)
    words += [str(word) for pair in pairs for word in pair]
    return [*words, *(["--strict"] if given.strict else [])]


class _FitOrder(Struct, frozen=True):
    """Options of the command.

    Attributes:
        again: The command line that resumes an interrupted fit.
    """

    output: Path | None
    fresh: bool
    anyway: bool
    force: bool
    gradient: bool
    diff: bool
    again: Sequence[str]


class _Task(Struct, frozen=True):
    """A learn block and the means to fit it."""

    compiled: "Compiled | None"
    block: "FitProblem | VocabularyFit"
    request: "Request"
    workers: "Workers"
    order: _FitOrder
    settings: Settings

    @property
    def target(self) -> Path | None:
        """Return the file of the preset, if there is one."""
        return self.order.output or self.block.write

    def report(self) -> Report:
        """Fit the block, or check its derivatives."""
        from tissuec.learn.fit.learning import Unlearnable
        from tissuec.scene.learning.model import VocabularyFit

        try:
            if isinstance(self.block, VocabularyFit):
                return _fit_words(self, self.block)
            assert self.compiled is not None
            if self.order.gradient:
                return _check_gradient(self.compiled, self.block, self.request)
            return _fit_data(self, self.compiled, self.block)
        except CompileError as error:
            return Report((), {}, WRONG_TEXT, error.diagnostics)
        except Unlearnable as error:
            return failed(error, STOPPED)
        except KeyboardInterrupt as error:
            again = shlex.join(self.order.again)
            parts = (
                Fact("", "interrupted", "failure"),
                Fact("", f"  resume with: {again}", "remark"),
            )
            code = exit_code(getattr(error, "signal", None))
            return Report(parts, {"error": "interrupted", "again": again}, code)

    def keep(self, sources: "Sequence[Source]", planned: Iterable[Path]) -> None:
        """Refuse to lose a text of the scene, or another file, before time is spent.

        Args:
            sources: The texts of the scene.
            planned: The files that will be written.
        """
        from tissuec.learn.presets.preset import refuse_others

        for source in sources if self.target is not None else ():
            if source.path is not None:
                assert self.target is not None
                keep_input(self.target, source.path)
        if not self.order.force:
            refuse_others(planned)

    def finished(
        self, document: dict[str, Any], files: Sequence[Path], doubt: str, *, is_fine: bool
    ) -> Report:
        """Return the rest of the report, when files are written.

        Args:
            document: What was learnt.
            files: The written files.
            doubt: The reason why it should not be used, if there is one.
            is_fine: Whether the doubt does not matter.
        """
        parts: list[Part] = [Fact("", f"wrote {file}", "remark") for file in files]
        if doubt and not is_fine:
            is_lost = self.target is not None and not files
            lost = "; no preset is written (to write it: --anyway)" if is_lost else ""
            parts.append(Fact("FAILED", f"{doubt}{lost}", "failure"))
        document["written"] = [str(file) for file in files]
        return Report(parts, document, DONE if is_fine else FAILED)


# --- parameters of a scene --------------------------------------------------------------------


def _fit_data(task: _Task, compiled: "Compiled", problem: "FitProblem") -> Report:
    """Fit parameters or words to measured data."""
    from tissuec.learn.fit.expense import expense_of
    from tissuec.learn.fit.learning import learn, rehearsal
    from tissuec.learn.fit.outcome import judged
    from tissuec.learn.fit.session import prepare
    from tissuec.learn.presets.preset import compose, place
    from tissuec.learn.report import (
        Passes,
        as_dict,
        differences,
        drifts,
        judged_parts,
        learnt_parts,
    )

    order, request, target, scene = task.order, task.request, task.target, compiled.scene
    if target is not None:
        task.keep((*scene.imports, scene.source), [target])
    session = prepare(compiled, problem, request)
    if target is not None:
        task.keep((), compose(rehearsal(session), compiled, request, target).files)
    state = _state(target, problem, request)
    state.parent.mkdir(parents=True, exist_ok=True)
    if state.exists() and not order.fresh:
        resumes = f"resumes from {state} if texts and data are unchanged (--fresh starts again)"
        task.settings.show(resumes, level="remark")
    if announcement := expense_of(session).announcement:
        task.settings.show(announcement, level="remark")
    with Passes(f"learn {problem.name}", shown=task.settings.shows_progress) as line:
        learnt = learn(
            compiled, problem, request, session=session, state=state, fresh=order.fresh,
            progress=line.at, workers=task.workers,
        )  # fmt: skip
    moved = drifts(scene, learnt.words)
    verdicts = judged(learnt)
    task.settings.show(*learnt_parts(learnt, moved), *judged_parts(verdicts))
    if order.diff:
        task.settings.show(Verbatim("".join(differences(scene, learnt.words))))
    doubt = _doubt(learnt, verdicts, strict=request.strict)
    may_write = order.anyway or not doubt
    files: Sequence[Path] = ()
    if may_write and target is not None:
        files = place(compose(learnt, compiled, request, target), force=order.force)
    if may_write:
        state.unlink(missing_ok=True)
    # What the data leaves open is no failure for those who want it anyway.
    is_fine = may_write and not _doubt(learnt, verdicts, identified=True)
    return task.finished(as_dict(learnt, moved), files, doubt, is_fine=is_fine)


def _doubt(
    learnt: "Learnt", verdicts: "Sequence[DemandVerdict]", *, strict: bool = False,
    identified: bool = False,
) -> str:  # fmt: skip
    """Return why the learnt numbers should not be used, empty if they can be.

    Args:
        learnt: What was learnt.
        verdicts: On its expectations.
        strict: Whether what a note doubts is a failure.
        identified: Whether to take parameters as identified.
    """
    from tissuec.learn.report import is_identified

    if learnt.failure:
        return learnt.failure
    if not identified and not is_identified(learnt):
        return "the data does not identify all parameters"
    if strict and learnt.doubts:
        return learnt.doubts[0]
    if not learnt.converged:
        return f"{learnt.reason}; increase passes, or start closer to the solution"
    return _failures(verdicts)


def _failures(verdicts: "Sequence[DemandVerdict]") -> str:
    """Return how many expectations failed, empty if all hold."""
    count = sum(not verdict.holds for verdict in verdicts)
    return f"{counted(count, 'expectation')} failed" if count else ""


def _state(target: Path | None, fit_problem: "FitProblem", request: "Request") -> Path:
    """Return where passes are kept: beside the preset, or in the current directory."""
    if target is not None:
        return target.with_name(target.name + KEPT)
    stem = Path(request.source.name).stem
    return Path(f"{stem}.{'_'.join(fit_problem.name.split())}{KEPT}")


def _check_gradient(compiled: "Compiled", problem: "FitProblem", request: "Request") -> Report:
    """Compare exact derivatives with differences."""
    from tissuec.learn.fit.gradient_check import check_gradient, gradient_report

    return gradient_report(problem.name, check_gradient(compiled, problem, request), GRADIENT)


# --- words of a vocabulary --------------------------------------------------------------------


def _fit_words(task: _Task, fit: "VocabularyFit") -> Report:
    """Fit words to the numbers of tissues.

    Raises:
        UsageError: A check of the derivatives of a motion was requested.
        TissueError: The vocabulary cannot be written to its file.
    """
    from tissuec.learn.presets.fitted_vocabulary import (
        compose_vocabulary,
        rehearse_vocabulary,
        sources_of,
    )
    from tissuec.learn.presets.preset import place
    from tissuec.learn.report import Passes, fitted_parts, judged_parts, unified
    from tissuec.learn.report import fitted_as_dict as as_dict
    from tissuec.learn.words_fit import fit_words
    from tissuec.pipeline import read_words

    order, request, target = task.order, task.request, task.target
    if order.gradient:
        raise click.UsageError(
            f"learn {fit.name} has no data, so there are no derivatives of a motion to check"
        )
    words = read_words(request)[0]
    sources = sources_of(fit, words)
    if target is not None:
        task.keep([*sources.values()], [target])
        task.keep((), rehearse_vocabulary(fit, words, request, target).files)
    with Passes(f"learn {fit.name}", shown=task.settings.shows_progress) as line:
        learnt = fit_words(request, fit, words, progress=line.at)
    verdicts = learnt.verdicts
    task.settings.show(*fitted_parts(learnt), *judged_parts(verdicts))
    if order.diff:
        before = {name: one.text for name, one in sources.items()}
        task.settings.show(Verbatim("".join(unified(before, learnt.texts))))
    doubt = _failures(verdicts) if learnt.converged else f"{learnt.reason}; increase passes"
    files: Sequence[Path] = ()
    if target is not None and (order.anyway or not doubt):
        files = place(compose_vocabulary(learnt, words, request, target), force=order.force)
    return task.finished(as_dict(learnt), files, doubt, is_fine=not doubt)
