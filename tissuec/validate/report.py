"""A validation as plain data for programs; ``summary`` makes text of it."""

from typing import Any

import numpy as np

from tissuec.core.data import as_data
from tissuec.model.network import Network
from tissuec.validate.compare import QuantityError
from tissuec.validate.validation import RunComparison, Validation


def as_dict(validation: Validation, network: Network) -> dict[str, Any]:
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


def _comparison(comparison: RunComparison, network: Network) -> dict[str, Any]:
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
    for body in network.bodies:
        if body.nodes.start <= node < body.nodes.stop:
            return f"{network.node_ids[node]} of {body.name}"
    return str(network.node_ids[node])
