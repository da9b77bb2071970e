"""The report on a validation: plain data, and parts from these data, also if read from JSON.

JSON has no infinity: ``None`` is a number that is not finite.
"""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from tissuec.core.data import as_data
from tissuec.core.report import (
    DONE,
    FAILED,
    STOPPED,
    FactSection,
    FactTable,
    Part,
    Report,
    failed,
)
from tissuec.core.units import TIME, show
from tissuec.model.network import Network
from tissuec.results.recording import body_of
from tissuec.validate.compare import QuantityError, dimension_of

if TYPE_CHECKING:
    from tissuec.validate.validation import RunComparison, Validation

#: Of each verdict: its sentence, the word before it in a terminal, and the exit code.
VERDICTS = {
    "kept": ("errors are within their limits", "PASS: ", DONE),
    "broken": ("errors exceed their limits", "FAIL: ", FAILED),
    "undecided": ("errors cannot be checked for the whole run", "UNDECIDED: ", FAILED),
    "nothing promised": ("errors have no limits with a fixed step", "NOT CHECKED: ", DONE),
    "diverged": ("the run could not continue", "", STOPPED),
}
COLUMNS = ("quantity", "error", "limit", "relative to", "worst at")
REMARK = "(…): not a limit, but the error that a position error at its limit could cause"

Document = Mapping[str, Any]


def validation_report(document: Document, facts: Document) -> Report:
    """Return the report on a validation.

    Args:
        document: From ``as_dict``, or only a verdict and the reason why there is no reference.
        facts: Further facts for programs.
    """
    code = VERDICTS[document["verdict"]][2]
    if "run" not in document:
        return failed(document["reasons"][0], code, **facts, **document)
    reasons = FactSection("", document["reasons"])
    parts = (*measured(document), verdict(document), reasons)
    return Report(parts, {**facts, **document}, code)


def measured(document: Document) -> list[Part]:
    """Return the errors, the events and the cost; nothing for a run that could not continue."""
    quantities = document.get("quantities", ())
    if not quantities:
        return []
    table = FactTable(COLUMNS, [*map(_row, quantities)], "Errors against SciPy")
    remarks = [REMARK] if any(one["expected"] is not None for one in quantities) else []
    return [table, *remarks, *_events(document), *_efforts(document)]


def as_dict(validation: "Validation", network: Network) -> dict[str, Any]:
    """Return all numbers, in SI units."""
    statistics = validation.run.outcome.statistics
    document: dict[str, Any] = {
        "verdict": validation.verdict,
        "reasons": list(validation.reasons),
        "tolerance": validation.tolerance,
        "output_times": validation.output_times,
        "compared_times": len(validation.run.times),
        **network.size.facts,
        "wall_time": validation.wall_time,
        "run": {
            "outcome": validation.run.outcome.kind,
            "message": validation.run.outcome.message,
            "wall_time": validation.run.outcome.wall_time,
            **as_data(statistics),
        },
    }
    if validation.comparison is not None:
        document |= _comparison(validation.comparison, network)
    return document


def _comparison(comparison: "RunComparison", network: Network) -> dict[str, Any]:
    known = comparison.known
    reference, second = known.reference, known.second
    return {
        "judged_until": comparison.judged,
        "quantities": [_quantity(quantity, network) for quantity in comparison.quantities],
        "ruptures": as_data(comparison.ruptures),
        "triggers": as_data(comparison.triggers),
        "reference": {
            "method": reference.method,
            "rtol": reference.rtol,
            "uncertainty": float(known.uncertainty[-1]),
            "is_sensitive": known.is_sensitive,
            "energy_imbalance": float(np.abs(reference.imbalance).max()),
            **as_data(reference.effort),
            "compared_with": {"rtol": second.rtol, **as_data(second.effort)},
        },
    }


def _quantity(quantity: QuantityError, network: Network) -> dict[str, Any]:
    node = None if quantity.node is None else _node(network, quantity.node)
    values = {name: getattr(quantity, name) for name in _NUMBERS}
    return values | {"kept": quantity.is_kept, "node": node}


_NUMBERS = ("name", "error", "bound", "expected", "scale", "time")


def _node(network: Network, node: int) -> str:
    """Return a node by the author's number and its body."""
    name = body_of(network, node)
    return f"{network.node_ids[node]} of {name}" if name else str(network.node_ids[node])


def _row(quantity: Document) -> tuple[str, ...]:
    promised = "-" if quantity["bound"] is None else f"{quantity['bound']:g}"
    if quantity["expected"] is not None:
        promised = f"({quantity['expected']:.1e})"
    where = show(_number(quantity["time"]), TIME)
    if quantity["node"] is not None:
        where += f", node {quantity['node']}"
    size = show(_number(quantity["scale"]), dimension_of(quantity["name"]))
    return quantity["name"], f"{_number(quantity['error']):.2e}", promised, size, where


def _events(document: Document) -> list[str]:
    """Return how ruptures and triggers of the run match those of the reference."""
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


def _efforts(document: Document) -> list[str]:
    """Return the costs of the run and the reference."""
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
    sentence, word, _ = VERDICTS[name]
    heading = f"{word}{sentence}"
    if tolerance is None or name == "diverged":
        return heading
    text = f"{heading} (tolerance {tolerance:g})"
    if name != "undecided" or "judged_until" not in document:
        return text
    until = document["judged_until"]
    if until is None or not math.isfinite(until):
        return f"{text}: not within limits at any time"
    return f"{text}: within limits until {show(until, TIME)}"


def _number(value: float | None) -> float:
    return math.nan if value is None else value
