"""Studies of a compiled scene: whether their measures, values and expectations fit it."""

from collections.abc import Iterator, Mapping, Sequence

from tissuec.compiler.checks.measures import saying_nothing, taken_in
from tissuec.compiler.checks.usage import breakable_entities
from tissuec.compiler.compile import Compiled
from tissuec.compiler.study.expectations import check_expectations
from tissuec.compiler.study.measures import StudyMeasure, compile_measures
from tissuec.core.errors import Diagnostic
from tissuec.scene.program.imports import Program
from tissuec.scene.study.levels import alone, check_levels
from tissuec.scene.study.model import Study

RUPTURE = "rupture"  # the kind of events


def check_studies(
    compiled: Compiled, program: Program, overrides: Sequence[str], *, levels: bool
) -> None:
    """Report what is wrong with the studies of a scene.

    Args:
        compiled: The scene.
        overrides: Texts of ``--set``.
        levels: Whether to try the values of the factors.

    Raises:
        CompileError: A study does not fit the scene.
    """
    findings = compiled.scene.constants.findings
    for study in compiled.scene.studies.values():
        failures = findings.failures
        measures, _ = compile_measures(compiled, study.measures)
        if findings.failures == failures:
            units = columns_of(study, measures)
            check_expectations(study.expects, units, compiled.scene.constants)
            for found in _idle_measures(compiled, study, measures):
                findings.add(found.code, found.message, found.span, hint=found.hint)
        if levels and study.is_whole:
            check_levels(study, alone(program), overrides, findings)
    findings.raise_errors()


def _idle_measures(
    compiled: Compiled, study: Study, measures: Sequence[StudyMeasure]
) -> Iterator[Diagnostic]:
    """Yield W703 and W404 of measures that say nothing of the scene as it is written."""
    places = {one.name: one.span for one in study.measures}
    for one in measures:
        yield from saying_nothing(compiled, taken_in(one.readings, places[one.name]))
    # Words, and breaking strains, may be what makes something rupture.
    if any(one.is_text or "breaking" in one.name for one in study.factors):
        return
    for one in measures:
        if one.event == RUPTURE:
            breakable = breakable_entities(compiled)
            if not (breakable if one.springs is None else breakable[one.springs]).any():
                yield Diagnostic(
                    "W404",
                    "nothing here can rupture, so this time never comes",
                    places[one.name],
                    "write rupture is allowed in a body, and a breaking strain in its tissue",
                )


def columns_of(study: Study, measures: Sequence[StudyMeasure]) -> Mapping[str, str]:
    """Return the units of the columns of numbers of a study, by name."""
    numbers = {factor.name: factor.unit for factor in study.factors if not factor.is_text}
    return numbers | {one.name: one.unit for one in measures if one.every is None}
