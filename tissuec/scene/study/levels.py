"""The values of a study, tried on the scene before it begins: words, units and limits."""

from collections.abc import Iterable, Iterator, Sequence

from tissuec.core.errors import Diagnostic
from tissuec.core.names import key_of
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.lang.walk import walk
from tissuec.scene.overrides.entries import SET
from tissuec.scene.overrides.idle import idle_overrides
from tissuec.scene.program.imports import Program
from tissuec.scene.reading.findings import Findings
from tissuec.scene.resolve import resolve
from tissuec.scene.study.model import Cell, Distribution, Factor, Levels, Study

MOST_NAMED = 8  # runs that a message names
#: Warnings about values: without effect, or far from the usual. That values contradict evidence
#: is often the purpose of a study.
DOUBTFUL = ("W205", "W504", "W505")


def alone(program: Program, *, expects: bool = False) -> Program:
    """Return the scene of a program without its learn and study blocks.

    Args:
        expects: Whether to keep what is expected of a run.
    """
    modules = (
        replace(one, items=tuple(i for i in one.items if not _is_beside(i, expects=expects)))
        for one in program.modules
    )
    return replace(program, modules=tuple(modules))


def _is_beside(item: s.Item, *, expects: bool) -> bool:
    """Return whether an item is about many runs, or about learning, or an expectation."""
    if isinstance(item, s.Expect):
        if not expects:
            return True
        calls = (part for part in walk(item.condition) if isinstance(part, s.Call))
        return any(call.function.key == "error" for call in calls)
    return isinstance(item, s.Block) and item.name.key.split(" ")[0] in ("learn", "study")


def check_levels(
    study: Study, program: Program, overrides: Sequence[str], findings: Findings
) -> None:
    """Report values of factors that the scene does not take.

    Args:
        study: The study, which is right by itself.
        program: Of the scene, as ``alone`` returns it.
        overrides: Texts of ``--set``.
    """
    scene = _TrialScene(study, program, overrides)
    for factor in study.factors:
        said: set[str] = set()  # of a factor that cannot vary, once is enough
        for value, place in _tried(factor):
            scene.report(factor, value, place, findings, said=said)


def check_rows(
    study: Study,
    rows: Sequence[Sequence[Cell | None]],
    program: Program,
    overrides: Sequence[str],
    findings: Findings,
) -> None:
    """Report values of runs that the scene does not take, with the runs that have them.

    Args:
        rows: Values of the factors for each run; None where the scene has its own.
        program: Of the scene, as ``alone`` returns it.
        overrides: Texts of ``--set``.
    """
    scene = _TrialScene(study, program, overrides)
    for place, factor in enumerate(study.factors):
        if isinstance(factor.spread, Levels):
            continue  # tried already
        runs: dict[Cell, list[int]] = {}
        for run, row in enumerate(rows):
            value = row[place]
            if value is not None:
                runs.setdefault(value, []).append(run)
        if factor.is_text:
            for value, them in runs.items():
                scene.report(factor, value, factor.span, findings, runs=them)
            continue
        numbers = sorted(value for value in runs if isinstance(value, float))
        bad = [*scene.bad(factor, numbers)]
        bad += [value for value in scene.bad(factor, numbers[::-1]) if value not in bad]
        if bad:
            them = sorted(run for value in bad for run in runs[value])
            scene.report(factor, bad[0], factor.span, findings, runs=them)


def _tried(factor: Factor) -> Iterable[tuple[Cell, Span]]:
    """Return each word of a factor, and the smallest and largest of its numbers."""
    match factor.spread:
        case Levels(values=values, places=places) if factor.is_text:
            return zip(values, places, strict=True)
        case Levels(values=values, places=places):
            order = sorted(range(len(values)), key=lambda n: values[n])
            return [(values[n], places[n]) for n in {order[0], order[-1]}]
        case Distribution("uniform", numbers):
            return [(number, factor.span) for number in numbers]
        case Distribution(numbers=numbers):
            return [(numbers[0], factor.span)]
        case None:
            return []


class _TrialScene:
    """A scene on which values are tried.

    Args:
        study: The study.
        program: Of the scene, as ``alone`` returns it.
        overrides: Texts of ``--set``.
    """

    def __init__(self, study: Study, program: Program, overrides: Sequence[str]):
        self.program, self.overrides = program, overrides
        self.first: dict[str, str] = {}
        #: Whether a factor chooses tissues, so that one may be in use in other runs only.
        self.varies_tissues = any(
            key_of(one.name).startswith("tissue") for one in study.factors
        )
        for place, factor in enumerate(study.factors):
            tried = [value for value, _ in _tried(factor)]
            if study.rows:
                tried = [study.rows[0][place]]
            if tried:
                self.first[factor.name] = factor.override(tried[0])

    def errors(self, factor: Factor, value: Cell) -> list[Diagnostic]:
        """Return what is wrong with a value, by itself and beside those of other factors."""
        return self._found(factor, value).errors

    def _found(self, factor: Factor, value: Cell) -> Findings:
        found = self._findings((factor.override(value),))
        if found.errors and len(self.first) > 1:
            others = (text for name, text in self.first.items() if name != factor.name)
            beside = self._findings((*others, factor.override(value)))
            return found if beside.errors else beside
        return found

    def _findings(self, texts: Sequence[str]) -> Findings:
        found = Findings()
        scene = resolve(self.program, found, (*self.overrides, *texts))
        if not found.errors and not self.varies_tissues:
            found.extend(idle_overrides(scene))
        return found

    def bad(self, factor: Factor, ordered: Sequence[float]) -> Iterator[float]:
        """Yield values from the first one on that are wrong, until one is right."""
        for value in ordered:
            if not self.errors(factor, value):
                return
            yield value

    def report(
        self,
        factor: Factor,
        value: Cell,
        place: Span,
        findings: Findings,
        *,
        runs: Sequence[int] = (),
        said: set[str] | None = None,
    ) -> None:
        """Report the first thing that is wrong with a value where the study has it.

        Without an error, that may be a warning that the value is without effect, or a slip.
        """
        named = ", ".join(str(run) for run in runs[:MOST_NAMED])
        more = f" and {len(runs) - MOST_NAMED} more" if len(runs) > MOST_NAMED else ""
        suffix = f" (run{'s' if len(runs) > 1 else ''} {named}{more})" if runs else ""
        found = self._found(factor, value)
        doubts = [one for one in found.warnings if one.code in DOUBTFUL and _is_set(one)]
        for one in [*found.errors, *doubts][:1]:
            about = "" if _is_set(one) else f"with {factor.override(value)}: "
            message = f"{about}{one.message}{suffix}"
            if said is not None:
                if message in said:
                    continue
                said.add(message)
            findings.add(one.code, message, place, hint=str(one.hint), notes=one.notes)


def _is_set(found: Diagnostic) -> bool:
    """Return whether a finding is about the text of a value."""
    return found.span is not None and found.span.source.name == SET
