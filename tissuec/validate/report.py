"""A validation as text for people and as plain data for programs."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from tissuec.core.units import TIME, show
from tissuec.network import Network
from tissuec.validate.compare import Quantity
from tissuec.validate.events import Matching
from tissuec.validate.validation import Comparison, Validation

HEADINGS = {
    "kept": "the promise is kept",
    "broken": "THE PROMISE IS BROKEN",
    "undecided": "the promise cannot be judged for the whole run",
    "nothing promised": "nothing was promised",
    "diverged": "the run could not go on",
}


def as_text(validation: Validation, network: Network) -> list[str]:
    """Return the report, line by line."""
    lines = []
    if validation.comparison is not None:
        lines += _table(validation.comparison, network)
        lines += _events(validation.comparison)
        lines += _efforts(validation, validation.comparison)
    lines.append(f"{HEADINGS[validation.verdict]}{_promise(validation)}")
    return [*lines, *(f"  {reason}" for reason in validation.reasons)]


def as_dict(validation: Validation, network: Network) -> dict[str, Any]:
    """Return all numbers, in SI units."""
    statistics = validation.run.outcome.statistics
    document: dict[str, Any] = {
        "verdict": validation.verdict,
        "reasons": list(validation.reasons),
        "tolerance": validation.tolerance,
        "output_times": validation.output_times,
        "compared_times": len(validation.run.times),
        "nodes": network.body_nodes,
        "springs": network.spring_count,
        "wall_time": validation.wall_time,
        "run": {
            "outcome": validation.run.outcome.kind,
            "message": validation.run.outcome.message,
            "wall_time": validation.run.outcome.wall_time,
            **asdict(statistics),
        },
    }
    if validation.comparison is not None:
        document |= _comparison(validation.comparison, network)
    return document


def _comparison(comparison: Comparison, network: Network) -> dict[str, Any]:
    known = comparison.known
    reference, second = known.reference, known.second
    return {
        "judged_until": comparison.judged,
        "quantities": [_quantity(quantity, network) for quantity in comparison.quantities],
        "ruptures": asdict(comparison.ruptures),
        "triggers": asdict(comparison.triggers),
        "reference": {
            "method": reference.method,
            "rtol": reference.rtol,
            "uncertainty": float(known.uncertainty[-1]),
            "is_sensitive": known.is_sensitive,
            "energy_imbalance": float(np.abs(reference.imbalance).max()),
            **asdict(reference.effort),
            "compared_with": {"rtol": second.rtol, **asdict(second.effort)},
        },
    }


def _quantity(quantity: Quantity, network: Network) -> dict[str, Any]:
    node = None if quantity.node is None else _node(network, quantity.node)
    values = {name: getattr(quantity, name) for name in _NUMBERS}
    return values | {"kept": quantity.is_kept, "node": node}


_NUMBERS = ("name", "error", "bound", "expected", "scale", "time")


def _table(comparison: Comparison, network: Network) -> list[str]:
    rows = [("quantity", "error", "promised", "relative to", "worst at")]
    for quantity in comparison.quantities:
        promised = "-" if quantity.bound is None else f"{quantity.bound:g}"
        if quantity.expected is not None:
            promised = f"({quantity.expected:.1e})"
        where = show(quantity.time, TIME)
        if quantity.node is not None:
            where += f", node {_node(network, quantity.node)}"
        size = show(quantity.scale, quantity.dimension)
        rows.append((quantity.name, f"{quantity.error:.2e}", promised, size, where))
    lines = _columns(rows)
    if any(quantity.expected is not None for quantity in comparison.quantities):
        lines.append("(…): not promised; what positions within the promise can do to it")
    return lines


def _columns(rows: Sequence[tuple[str, ...]]) -> list[str]:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]


def _events(comparison: Comparison) -> list[str]:
    lines = []
    for what, matching in (
        ("springs broke", comparison.ruptures),
        ("triggers fired", comparison.triggers),
    ):
        if matching.run or matching.reference:
            lines.append(f"{what}: {_matching(matching)}")
    return lines


def _matching(matching: Matching) -> str:
    if matching.misses:
        return f"{matching.run} in the run, {matching.reference} in the reference"
    order = "in the same order" if matching.in_order else "in another order"
    return (
        f"{matching.run} in both, {order}; times differ by up to {show(matching.error, TIME)}"
    )


def _efforts(validation: Validation, comparison: Comparison) -> list[str]:
    outcome, known = validation.run.outcome, comparison.known
    statistics, reference = outcome.statistics, known.reference
    effort = reference.effort
    compared = len(validation.run.times)
    every = f" of {validation.output_times}" if compared < validation.output_times else ""
    return [
        f"run: {statistics.method}, {statistics.accepted} steps, {outcome.wall_time:.2f} s",
        f"reference: SciPy {reference.method}, rtol {reference.rtol:.0e}, "
        f"{effort.steps} steps, {effort.wall_time:.2f} s; known to "
        f"{known.uncertainty[-1]:.1e} (against rtol {known.second.rtol:.0e})",
        f"compared at {compared}{every} output times",
    ]


def _promise(validation: Validation) -> str:
    if validation.tolerance is None or validation.verdict == "diverged":
        return ""
    text = f" (tolerance {validation.tolerance:g})"
    comparison = validation.comparison
    if validation.verdict == "undecided" and comparison is not None:
        if not np.isfinite(comparison.judged):
            return f"{text}: at no time"
        return f"{text}: kept until {show(comparison.judged, TIME)}"
    return text


def _node(network: Network, node: int) -> str:
    """Return a node by the author's number and its body."""
    for body in network.bodies:
        if body.nodes.start <= node < body.nodes.stop:
            return f"{network.node_ids[node]} of {body.name}"
    return str(network.node_ids[node])
