"""Whether what follows from a potential is finite in a state, such as at rest."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tissuec.autodiff.derivatives import partials
from tissuec.autodiff.evaluation import evaluate, failing
from tissuec.autodiff.graph import Number, TracingError
from tissuec.autodiff.potentials import TracedItem
from tissuec.autodiff.tracing import LocatedGraph, place_of

REMEDY = "clamp the argument, such as by maximum(…, TINY), or write norm for a length"


def probe(item: TracedItem, values: Mapping[str, Any]) -> None:
    """Check that energies, forces and matrices of items are finite.

    Args:
        values: Of all inputs, by name: numbers, or arrays of many items.

    Raises:
        TracingError: One is not; with the line of the function that is responsible.
    """
    outputs = [item.energy, item.dissipation, *item.forces, *_second(item)]
    if all(np.isfinite(each).all() for each in evaluate(outputs, values)):
        return
    # Traced once more, with lines.
    graph = LocatedGraph()
    item = TracedItem(item.function, item.corners, item.widths, graph)
    own, written = [item.energy, item.dissipation], len(graph.operations)
    if failure := failing(own, values):
        _reject(graph.lines[failure.place], failure.text)
    for place in graph.reached(own):
        slopes = [slope for _, slope in partials(graph, place)] if place < written else []
        if slopes and (failure := failing([*own, *slopes], values)):
            name = graph.operations[place].name
            _reject(graph.lines[place], f"{name} has no derivative: {failure.text}")
    for what, outputs in (("forces", item.forces), ("matrices", _second(item))):
        if failure := failing(outputs, values):
            _reject(place_of(item.function), f"{what} are not finite: {failure.text}")


def _second(item: TracedItem) -> Sequence[Number]:
    """Return the entries of both matrices of an item."""
    return [*item.matrix.values(), *item.damping_by_velocity.values()]


def _reject(place: str, text: str) -> None:
    raise TracingError(f"{place}: {text}: {REMEDY}")
