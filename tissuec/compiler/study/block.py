"""Studies of a compiled scene: whether their measures, values and expectations fit it."""

from collections.abc import Mapping, Sequence

from tissuec.compiler.compile import Compiled
from tissuec.compiler.study.expectations import check_expectations
from tissuec.compiler.study.measures import StudyMeasure, compile_measures
from tissuec.scene.program.imports import Program
from tissuec.scene.study.levels import alone, check_levels
from tissuec.scene.study.model import Study


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
        if levels and study.is_whole:
            check_levels(study, alone(program), overrides, findings)
    findings.raise_errors()


def columns_of(study: Study, measures: Sequence[StudyMeasure]) -> Mapping[str, str]:
    """Return the units of the columns of numbers of a study, by name."""
    numbers = {factor.name: factor.unit for factor in study.factors if not factor.is_text}
    return numbers | {one.name: one.unit for one in measures if one.every is None}
