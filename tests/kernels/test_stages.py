"""Combinations of stages, against sums of NumPy, in pieces and by several threads."""

import numpy as np
import pytest

from tests.validate.scenes import compiled_scene
from tissuec.compiled.calls import Shipped
from tissuec.engine.integrators import INTEGRATORS
from tissuec.engine.layout import layout_of
from tissuec.engine.run_arrays import new_work
from tissuec.engine.threads import ThreadTeam
from tissuec.kernels import stages

H = 0.25
SHEET = """language 1
tissue t { spring constant = 1 N/m; viscosity = 0 N*s/m; mass = 1 g }
body sheet {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (9, 0, 0) mm; second edge = (0, 9, 0) mm
    columns = 2; rows = ROWS; diagonals is both
  }
  tissue is t
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 s }
"""


def compiled(function):
    return Shipped(function, "stages")


@pytest.fixture(params=[1, 2], ids=["one thread", "two threads"])
def work(request):
    """State and stages of a net longer than one stretch, all random."""
    count = stages.STRETCH // 3 + 100
    network = compiled_scene(SHEET.replace("ROWS", str(count // 2))).network
    random = np.random.default_rng(4)
    with ThreadTeam(request.param, count) as team:
        made = new_work(INTEGRATORS["dop853"], network, team.record, layout_of(network, 1))
        for vectors in (made.x, made.v, made.a, made.rows):
            vectors[:] = random.normal(size=vectors.shape)
        yield made


def rows_of(current, work):
    """Return what a tableau weights: v / h, accelerations at both ends, and further rows."""
    rows = work.rows.copy()
    rows[0], rows[1], rows[work.end_row] = (
        work.v[current] / H,
        work.a[current],
        work.a[1 - current],
    )
    return rows


WEIGHTS = {
    "all rows": lambda count, end: np.random.default_rng(5).normal(size=count),
    "first rows": lambda count, end: np.eye(count)[0] + np.eye(count)[1],
    "the end": lambda count, end: np.eye(count)[end],
    "one row": lambda count, end: np.eye(count)[count - 1],
    "every second row": lambda count, end: np.arange(count) % 2.0,
    "none": lambda count, end: np.zeros(count),
}


@pytest.mark.parametrize(
    ("of", "current"),
    [(lambda f: f, 0), (compiled, 0), (compiled, 1)],
    ids=["Python", "compiled", "compiled, the other place"],
)
@pytest.mark.parametrize("chosen", WEIGHTS)
def test_rows_are_combined_by_their_weights(of, chosen, current, work):
    for_x = WEIGHTS[chosen](len(work.rows), work.end_row)
    for_v = np.roll(for_x, 1)
    rows, x, v = rows_of(current, work), np.zeros_like(work.zero), np.zeros_like(work.zero)
    base = work.x[current], work.zero
    of(stages.combine)(*base, H, for_x, for_v, current, x, v, work)
    # Sums of at most 18 products of numbers near 1, in another order.
    assert x == pytest.approx(work.x[current] + H**2 * for_x @ rows, rel=0, abs=1e-13)
    assert v == pytest.approx(H * for_v @ rows, rel=0, abs=1e-13)


@pytest.mark.parametrize("of", [lambda f: f, compiled], ids=["Python", "compiled"])
def test_rows_without_a_weight_are_not_read(of, work):
    weights = np.zeros(len(work.rows))
    weights[[1, 4]] = 1.0, 2.0
    expected = work.a[0] + 2.0 * work.rows[4]
    work.v[0], work.a[1] = np.nan, np.nan
    work.rows[[*range(4), *range(5, len(work.rows))]] = np.nan
    x, v = np.zeros_like(work.zero), np.zeros_like(work.zero)
    of(stages.combine)(work.zero, work.zero, 1.0, weights, weights, 0, x, v, work)
    assert x == pytest.approx(expected, rel=1e-15)
    assert v == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize("of", [lambda f: f, compiled], ids=["Python", "compiled"])
@pytest.mark.parametrize("begin", [0, 7])
def test_blended_errors_are_those_of_the_worst_node(of, begin, work):
    rows, table = rows_of(0, work), work.tableau
    of(stages.blended_errors)(H, 0, work.each[begin:], begin, work)
    for errors, factor, found in zip(
        (table.error_x, table.error_v), (H**2, H), work.errors, strict=True
    ):
        five, three = (factor * errors @ rows[: errors.shape[1]]).reshape(2, -1, 3)
        squares = (five**2).sum(axis=1), (three**2).sum(axis=1)
        blended = squares[0] / np.sqrt(squares[0] + 0.01 * squares[1])
        assert found == pytest.approx(blended[begin:].max(), rel=1e-12)  # other order of sums


@pytest.mark.parametrize("of", [lambda f: f, compiled], ids=["Python", "compiled"])
def test_errors_that_are_no_numbers_are_not_lost(of, work):
    work.rows[6, 3 * (stages.STRETCH // 3) + 5] = np.nan
    of(stages.blended_errors)(H, 0, work.each, 0, work)
    assert np.isnan(work.errors).all()
