"""The report on a study, the summary of its table, and its progress line."""

import time as clock
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from tissuec.core.errors import counted
from tissuec.core.progress import ProgressLine, minutes
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
from tissuec.studies.table import Column, StudyTable, title

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
        "without_effect": list(table.idle_factors),
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
    for name in table.idle_factors:
        yield Fact("note", f"{name} changes no measure: its values give equal rows")
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


def summary(table: StudyTable, path: Path) -> dict[str, Any]:
    """Return a summary of a table, with ranges in the units of its columns.

    Args:
        path: Its file.
    """
    head, table = table.head, table.shown
    return {
        "file": str(path),
        "bytes": path.stat().st_size,
        "study": head.name,
        "scene": head.scene,
        "design": head.design,
        "runs": f"{len(table)} of {head.planned}",
        "outcomes": dict(Counter(table.outcome)),
        "accuracy": promises(table),
        "doubtful": doubtful(table),
        "factors": {one.title: values_of(one) for one in table.factors},
        "measures": {one.title: range_of(table, one) for one in table.measures},
        "curves": {title(one.name, one.unit): f"every {one.every:g} s" for one in table.curves},
    }


def promises(table: StudyTable) -> dict[str, int]:
    """Return how many runs kept their tolerance, broke it, or do not know."""
    return dict(Counter(promise.split(" from ")[0] for promise in table.promise))


def doubtful(table: StudyTable) -> dict[str, int]:
    """Return how many runs have doubts of each kind, and of any kind as "runs"."""
    found = [doubts for doubts in table.doubts if doubts]
    each = Counter(kind for doubts in found for kind in doubts.split(", "))
    return {"runs": len(found), **each} if found else {}


def doubts_in_words(table: StudyTable) -> str:
    """Return how many runs have doubts, and how many of each kind; empty if none has any."""
    found = doubtful(table)
    each = ", ".join(f"{count} {kind}" for kind, count in found.items() if kind != "runs")
    return f"{counted(found['runs'], 'run')} ({each})" if found else ""


def values_of(factor: Column) -> str:
    """Return the values of a factor: words, or numbers from the smallest to the largest."""
    if isinstance(factor.values, tuple):
        return ", ".join(dict.fromkeys(factor.values))
    known = np.unique(factor.numbers[np.isfinite(factor.numbers)])
    if len(known) <= 6:
        return ", ".join(f"{value:g}" for value in known)
    return f"{known[0]:g} to {known[-1]:g} ({len(known)} values)"


def range_of(table: StudyTable, measure: Column) -> str:
    """Return the range of a measure over the runs that finished, with its median."""
    found = completed(table, measure)
    if not len(found.rows):
        return f"no value; {found.left_out}"
    low, middle, high = np.quantile(measure.numbers[found.rows], [0.0, 0.5, 1.0])
    text = f"{low:.4g} to {high:.4g}, median {middle:.4g}"
    return f"{text}; {found.left_out}" if found.left_out.count else text


class StudyProgress(ProgressLine):
    """The line of a study; see `ProgressLine`."""

    def __init__(self, name: str, *, shown: bool, anywhere: bool = False):
        super().__init__(called(name), shown=shown, anywhere=anywhere)
        self.first: tuple[float, int] | None = None

    def at(self, done: int, failed: int, planned: int) -> None:
        """Show how far the study is, if it is time to.

        Args:
            done: Runs with a row.
            failed: Those of them that failed.
            planned: Runs of the whole study.
        """
        if self.first is None:
            self.first = clock.monotonic(), done
        self.show(lambda now: self._text(now, done, failed, planned))

    def _text(self, now: float, done: int, failed: int, planned: int) -> str:
        assert self.first is not None
        began, before = self.first
        bad = f", {failed} failed" if failed else ""
        each = (now - began) / (done - before) if done > before else 0.0
        left = f", {minutes(each * (planned - done))} left" if each else ""
        return f"{self.name}: {done} of {planned} runs{bad}{left}"
