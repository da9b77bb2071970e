"""Summary of the table of a study, as text and for ``--json``."""

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from tissuec.core.errors import counted
from tissuec.studies.analysis.completed import completed
from tissuec.studies.rows import title
from tissuec.studies.table import Column, StudyTable


def summary(table: StudyTable, path: Path) -> dict[str, Any]:
    """Return a summary of a table, with ranges in the units of its columns.

    Args:
        table: The table.
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
    """Return the range of a measure over the runs that came to an end, with its median.

    Args:
        table: The table.
        measure: The measure.
    """
    found = completed(table, measure)
    if not len(found.rows):
        return f"no value; {found.left_out}"
    low, middle, high = np.quantile(measure.numbers[found.rows], [0.0, 0.5, 1.0])
    text = f"{low:.4g} to {high:.4g}, median {middle:.4g}"
    return f"{text}; {found.left_out}" if found.left_out.count else text
