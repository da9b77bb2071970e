"""Functions that cannot be traced, or are not finite: errors with their lines and a way out."""

import inspect
import math

import numpy as np
import pytest

from tests.every import every
from tissuec.autodiff import (
    Potential,
    TracingError,
    Vector,
    dot,
    exp,
    log,
    maximum,
    norm,
    sqrt,
    square,
    where,
)
from tissuec.autodiff.evaluation import evaluate
from tissuec.autodiff.potentials import TracedItem
from tissuec.autodiff.probe import probe

WIDTHS = {"stiffness": 1, "both": 2}


def branches(x, v, p):
    if x[0][0] > 0.0:  # here
        return p.stiffness * x[0][0]
    return p.stiffness


def chooses(x, v, p):
    return max(p.stiffness, 1.0)  # here


def takes_math(x, v, p):
    length = math.sqrt(square(x[0]))  # here
    return p.stiffness * length


def takes_numpy(x, v, p):
    return p.stiffness * np.sqrt(square(x[0]))  # here


def within_numpy(x, v, p):
    return p.stiffness * np.linalg.norm(x[0])  # here


def takes_arrays(x, v, p):
    return p.stiffness * np.ones(3)  # here


def compares(x, v, p):
    depth = x[0][2]
    return where(depth >= 0.0, depth, 0.0)  # here


def is_equal(x, v, p):
    return 0.0 if p.stiffness == 0.0 else p.stiffness  # here


def counts_conditions(x, v, p):
    return p.stiffness * (x[0][0] > 0.0)  # here


def misspells(x, v, p):
    return p.stifness * square(x[0])  # here


def adds_vectors(x, v, p):
    return p.stiffness + x[0]  # here


def divides_with_rest(x, v, p):
    return p.stiffness % 2.0  # here


def returns_nothing(x, v, p):  # here
    p.stiffness * square(x[0])


def returns_points(x, v, p):  # here
    return x[0]


def stores_motion(x, v, p):  # here
    return p.stiffness * square(v[0])


FAULTS = {
    branches: r"it branches on a number: write where\(condition, one, other\)",
    chooses: r"it branches on a number: write where\(",
    takes_math: "it needs the value of a number: write functions of tissuec.autodiff, such as",
    takes_numpy: "it takes sqrt of numpy: write functions of tissuec.autodiff, such as sqrt",
    within_numpy: "of numpy: write functions of tissuec.autodiff",
    takes_arrays: "it fails with TypeError: only ",
    compares: "it compares numbers by >= or <=: write > or <",
    is_equal: r"it compares a number by == or !=: write where\(",
    counts_conditions: r"it computes with a condition: write where\(condition, 1.0, 0.0\)",
    misspells: 'an item has no number "stifness"; it has stiffness, both',
    adds_vectors: "it computes with a Vector as if it were a number",
    divides_with_rest: "it fails with TypeError: unsupported operand",
    returns_nothing: r"it has to return an energy, or Potential\(energy, dissipation\)",
    returns_points: "it has to return an energy",
    stores_motion: r"its energy depends on velocities: return Potential\(energy, dissipation\)",
}


def place(function):
    lines, first = inspect.getsourcelines(function)
    (marked,) = (k for k, line in enumerate(lines) if "# here" in line)
    return f"{inspect.getsourcefile(function)}:{first + marked}: "


@every("function", FAULTS, ids=lambda function: function.__name__)
def test_what_cannot_be_traced_is_told_with_its_line_and_what_to_write(function):
    with pytest.raises(TracingError, match=FAULTS[function]) as caught:
        TracedItem(function, 2, WIDTHS)
    assert str(caught.value).startswith(place(function))


def test_numbers_of_numpy_and_of_python_are_constants():
    def plain(x, v, p):
        return (
            abs(p.stiffness * np.int64(2)) + np.float64(3.0) * x[0][0] + np.dot([1, 2, 3], x[1])
        )

    def same(x, v, p):
        return maximum(2 * p.stiffness, -2 * p.stiffness) + 3 * x[0][0] + dot([1, 2, 3], x[1])

    at = AT_REST | {"x.0.0": 0.7, "x.1.2": -1.1}
    one, other = (evaluate([TracedItem(each, 2, WIDTHS).energy], at) for each in (plain, same))
    assert np.array_equal(one, other)


# --- numbers that are not finite --------------------------------------------------------------


def has_no_direction(x, v, p):
    e = x[1] - x[0]
    length = sqrt(dot(e, e))  # here
    return 0.5 * p.stiffness * (length - 1.0) ** 2


def divides_by_nothing(x, v, p):
    e = x[1] - x[0]
    return p.stiffness * e[0] / dot(e, e)  # here


def leaves_numbers(x, v, p):
    return p.stiffness * log(p.stiffness - 2.0) * square(x[0])  # here


def bends_at_once(x, v, p):  # here
    return p.stiffness * square(x[1] - x[0]) ** 0.75


def brakes_at_once(x, v, p):
    return Potential(0.0, p.stiffness * sqrt(square(v[0])))  # here


def chooses_too_late(x, v, p):
    length = norm(x[1] - x[0])
    return p.stiffness * where(length > 0.1, 1.0 / length, 10.0)  # here


PROBED = {
    chooses_too_late: r"quotient\(1, 0\) = inf: clamp the argument",
    has_no_direction: r"sqrt has no derivative: quotient\(0.5, 0\) = inf: clamp the argument",
    divides_by_nothing: r"quotient\(0, 0\) = nan: clamp the argument",
    leaves_numbers: r"log\(-1\) = nan: ",
    bends_at_once: "power has no derivative|matrices are not finite",
    brakes_at_once: "sqrt has no derivative",
}
AT_REST = {f"{letter}.{k}.{axis}": 0.0 for letter in "xv" for k in (0, 1) for axis in range(3)}
AT_REST |= {"p.stiffness.0": np.array([1.0, 1.0]), "p.both.0": 1.0, "p.both.1": 1.0}


@every("function", PROBED, ids=lambda function: function.__name__)
def test_what_is_not_finite_at_rest_is_told_with_its_line(function):
    with pytest.raises(TracingError, match=PROBED[function]) as caught:
        probe(TracedItem(function, 2, WIDTHS), AT_REST)
    if function is not bends_at_once:
        assert str(caught.value).startswith(place(function))


def test_what_is_finite_passes_the_probe():
    def fine(x, v, p):
        e = x[1] - x[0]
        near = where(norm(e) > 0.1, 1.0 / maximum(norm(e), 0.1), 10.0)
        return Potential(p.stiffness * (near - 1.0) ** 2 * exp(-norm(e)), square(v[0]))

    probe(TracedItem(fine, 2, WIDTHS), AT_REST)


def test_an_energy_is_held_that_changes_where_all_nodes_move_alike():
    def held(x, v, p):
        return square(x[0] + x[1] - 2.0 * Vector((p.stiffness, *[p.stiffness] * 2)))

    free, held = (TracedItem(each, 2, WIDTHS).is_held for each in (has_no_direction, held))
    assert held and not free
