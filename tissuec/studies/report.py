"""The report on a study."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tissuec.core.errors import counted
from tissuec.core.report import (
    DONE,
    FAILED,
    STOPPED,
    Fact,
    FactSection,
    FailedExpectation,
    Part,
    Report,
    holding,
)
from tissuec.scene.study.model import called
from tissuec.studies.analysis.completed import completed
from tissuec.studies.study import RUNS, PreparedStudy, StudyResult
from tissuec.studies.summary import doubtful, doubts_in_words

MOST_REASONS = 5  # of failed runs that are listed


def study_report(
    scene: str,
    prepared: PreparedStudy,
    result: StudyResult,
    target: Path,
    diagnostics: list[dict[str, Any]],
) -> Report:
    """Return the report on a study.

    Args:
        scene: The path of the scene.
        prepared: The study.
        result: Its table and verdicts.
        target: The file of the table.
        diagnostics: Warnings about the text.
    """
    table, verdicts = result.table, result.verdicts
    code = DONE if all(verdict.holds for verdict in verdicts) else FAILED
    code = code if table.finished.any() else STOPPED
    document = {
        "scene": scene,
        "study": prepared.study.name,
        "table": str(target),
        "runs": len(table),
        "taken_over": result.taken_over,
        "outcomes": dict(Counter(table.outcome)),
        "doubtful": doubtful(table),
        "expectations": [
            {"expect": one.expect, "holds": one.holds, "measured": one.measured}
            for one in verdicts
        ],
        "wall_time": result.seconds,
        "diagnostics": diagnostics,
    }
    parts = [*_said(result)]
    if prepared.keeps:
        parts.append(Fact("results", str(target.with_suffix(RUNS))))
    parts.append(Fact("table", str(target)))
    taken = f", {result.taken_over} of them done before" if result.taken_over else ""
    name, count = called(table.head.name), counted(len(table), "run")
    title = f"{scene}: {name}: {count}{taken}; {result.seconds:.1f} s"
    section = FactSection(title, parts, apart=False)
    return Report([section], document, code, level="remark")


def _said(result: StudyResult) -> Iterator[Part]:
    table, verdicts = result.table, result.verdicts
    yield from (Fact(name, str(count)) for name, count in Counter(table.outcome).items())
    reasons = Counter(reason for reason in table.reason if reason)
    for reason, count in reasons.most_common(MOST_REASONS):
        yield FactSection("", [Fact(counted(count, "run"), reason)])
    promises = Counter(promise.split(" ")[0] for promise in table.promise)
    for promise in ("broken", "unknown"):
        if promises[promise]:
            yield Fact(f"accuracy {promise}", counted(promises[promise], "run"))
    if doubts := doubts_in_words(table):
        yield Fact("doubtful", doubts)
    yield from (
        FailedExpectation(f"{one.span.place}: {one.expect}", one.measured)
        for one in verdicts
        if not one.holds
    )
    if verdicts:
        states = ["holds" if verdict.holds else "fails" for verdict in verdicts]
        left_out = completed(table).left_out
        beside = f" ({left_out})" if left_out.count else ""
        yield Fact("expectations", f"{holding(states)}{beside}")
