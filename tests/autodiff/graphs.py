"""Random graphs, and derivatives of graphs that share nothing with ``autodiff.derivatives``."""

from collections.abc import Sequence

import numpy as np

from tissuec import autodiff
from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.graph import Graph, Number, Operation

STEP = 1e-100  # of complex steps, whose square vanishes beside any number

#: Operations on numbers within ±2, whose results are about as large.
OPERATIONS = [
    lambda a, b: a + b,
    lambda a, b: 1.5 * a - b,
    lambda a, b: -a,
    lambda a, b: 0.5 * (a * b),
    lambda a, b: a / (3.0 + b * b),
    lambda a, b: 0.1 * a**3,
    lambda a, b: (2.0 + a * a) ** (0.2 * b),
    lambda a, b: (2.0 + a * a) ** -0.7,
    lambda a, b: 1.2 ** (0.3 * a),
    lambda a, b: autodiff.sqrt(1.0 + a * a),
    lambda a, b: autodiff.exp(-a * a),
    lambda a, b: autodiff.log(2.0 + a * a),
    lambda a, b: autodiff.sin(a + b),
    lambda a, b: autodiff.cos(a - b),
    lambda a, b: autodiff.maximum(a, 0.3 * b),
    lambda a, b: autodiff.minimum(a, 0.2 + b),
    lambda a, b: autodiff.where(a > b, a * a, 0.3 * b),
    lambda a, b: autodiff.norm(autodiff.Vector((a, b, a * b))),
]


def random_number(inputs: Sequence[Number], seed: int, length: int = 30) -> Number:
    """Return a number that depends on all inputs by operations drawn at random."""
    chance, found = np.random.default_rng(seed), list(inputs)
    for _ in range(length):
        a, b = (found[k] for k in chance.integers(max(0, len(found) - 8), len(found), size=2))
        found.append(OPERATIONS[chance.integers(len(OPERATIONS))](a, b))
    total = found[-1]
    for k, each in enumerate(found[:-1]):
        total = total + (0.3 + 0.01 * k) * each
    return total


def by_complex_steps(outputs: Sequence[Number], values: dict[str, float], name: str):
    """Return the derivatives of outputs by one input (W. Squire, G. Trapp, 1998)."""
    moved = {key: complex(value) for key, value in values.items()}
    moved[name] += 1j * STEP
    return np.array([each.imag / STEP for each in evaluate(outputs, moved)])


def formula(number: Number) -> Number:
    """Return a number in a graph of its own without the rules of derivatives."""
    graph, copies = Graph(), dict[int, Number]()
    for place in number.graph.reached([number]):
        name, arguments, detail = number.graph.operations[place]
        if name == "ruled":
            copies[place] = copies[arguments[0]]
        else:
            own = tuple(copies[each].place for each in arguments)
            copies[place] = graph.record(Operation(name, own, detail))
    return copies[number.place]
