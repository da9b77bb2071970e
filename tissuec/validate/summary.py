"""A validation in words and rows, from its plain data: as it was made, or read from JSON.

JSON has no infinity, so that ``None`` stands for a number that is not finite.
"""

import math
from collections.abc import Mapping
from typing import Any

from tissuec.core.columns import aligned
from tissuec.core.units import TIME, show
from tissuec.validate.compare import dimension_of

#: What each verdict says, and the word that a reader looks for before it.
HEADINGS = {
    "kept": "errors are within their limits",
    "broken": "errors exceed their limits",
    "undecided": "errors cannot be checked for the whole run",
    "nothing promised": "errors have no limits with a fixed step",
    "diverged": "the run could not continue",
}
WORDS = {
    "kept": "PASS: ",
    "broken": "FAIL: ",
    "undecided": "UNDECIDED: ",
    "nothing promised": "NOT CHECKED: ",
}
COLUMNS = ("quantity", "error", "limit", "relative to", "worst at")
REMARK = "(…): not a limit, but the error that a position error at its limit could cause"

Document = Mapping[str, Any]


def as_text(document: Document) -> list[str]:
    """Return the report, line by line.

    Args:
        document: What ``tissuec.validate.report.as_dict`` returned.
    """
    rows = table(document)
    lines = aligned([COLUMNS, *rows]) if rows else []
    lines += [*remarks(document), *events(document), *efforts(document), verdict(document)]
    return [*lines, *(f"  {reason}" for reason in document["reasons"])]


def table(document: Document) -> list[tuple[str, ...]]:
    """Return the rows below ``COLUMNS``; none for a run that could not continue."""
    return [_row(quantity) for quantity in document.get("quantities", ())]


def _row(quantity: Document) -> tuple[str, ...]:
    promised = "-" if quantity["bound"] is None else f"{quantity['bound']:g}"
    if quantity["expected"] is not None:
        promised = f"({quantity['expected']:.1e})"
    where = show(_number(quantity["time"]), TIME)
    if quantity["node"] is not None:
        where += f", node {quantity['node']}"
    size = show(_number(quantity["scale"]), dimension_of(quantity["name"]))
    return quantity["name"], f"{_number(quantity['error']):.2e}", promised, size, where


def remarks(document: Document) -> list[str]:
    """Return the remarks below the table."""
    quantities = document.get("quantities", ())
    return [REMARK] if any(one["expected"] is not None for one in quantities) else []


def events(document: Document) -> list[str]:
    """Return how what broke and what fired match."""
    lines: list[str] = []
    for what, name in (("springs broke", "ruptures"), ("triggers fired", "triggers")):
        matching = document.get(name)
        if matching is not None and (matching["run"] or matching["reference"]):
            lines.append(f"{what}: {_matching(matching)}")
    return lines


def _matching(matching: Document) -> str:
    if matching["misses"]:
        return f"{matching['run']} in the run, {matching['reference']} in the reference"
    order = "in the same order" if matching["in_order"] else "in another order"
    error = show(_number(matching["error"]), TIME)
    return f"{matching['run']} in both, {order}; times differ by up to {error}"


def efforts(document: Document) -> list[str]:
    """Return the costs of the run and the reference."""
    if "reference" not in document:
        return []
    run, reference = document["run"], document["reference"]
    compared, possible = document["compared_times"], document["output_times"]
    every = f" of {possible}" if compared < possible else ""
    return [
        f"run: {run['method']}, {run['accepted']} steps, {run['wall_time']:.2f} s",
        f"reference: SciPy {reference['method']}, rtol {reference['rtol']:.0e}, "
        f"{reference['steps']} steps, {reference['wall_time']:.2f} s; accurate to "
        f"{_number(reference['uncertainty']):.1e} "
        f"(compared with rtol {reference['compared_with']['rtol']:.0e})",
        f"compared at {compared}{every} output times",
    ]


def verdict(document: Document) -> str:
    """Return the verdict, as a sentence without its stop."""
    name, tolerance = document["verdict"], document.get("tolerance")
    heading = WORDS.get(name, "") + HEADINGS[name]
    if tolerance is None or document["verdict"] == "diverged":
        return heading
    text = f"{heading} (tolerance {tolerance:g})"
    if document["verdict"] != "undecided" or "judged_until" not in document:
        return text
    until = document["judged_until"]
    if until is None or not math.isfinite(until):
        return f"{text}: not within limits at any time"
    return f"{text}: within limits until {show(until, TIME)}"


def _number(value: float | None) -> float:
    return math.nan if value is None else value
