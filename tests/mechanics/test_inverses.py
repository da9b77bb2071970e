"""Large nets are solved by iterations as they are by factors, stable or not."""

import numpy as np
import pytest

import tissuec
from tests.counting import counted
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.mechanics import inverses
from tissuec.mechanics.balance import Balance
from tissuec.mechanics.dissection import blocks_of
from tissuec.mechanics.inverses import Indefinite, Inverses, Iterations
from tissuec.mechanics.multigrid import Multigrid, aggregates
from tissuec.mechanics.settling import BUCKLED, Unsettled, settle
from tissuec.mechanics.stability import is_firm, softest
from tissuec.mechanics.stiffness import Factorization

BLOCK = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = {ratio}; density = 1000 kg/m^3 }}
body block {{
  mesh is lattice {{ cell = {cell} mm; box from (0, 0, 0) mm to {box} mm }}; tissue is gel
}}
set base = nodes of block where z < 0.01 mm
set top = nodes of block where z > {high} mm
environment {{ gravity = ({gravity}, 0, 0) m/s^2 }}
script {{ at 0 s: {{ fix base; hold top }} }}
simulate {{ duration = 1 s; integrator is equilibrium; step = 1 s }}
output {{ force(base) every 1 s }}
"""


def block(cell, box=(20, 20, 20), ratio=0.3, gravity=0, *, held=True):
    text = BLOCK.format(cell=cell, box=box, ratio=ratio, gravity=gravity, high=box[2] - 0.01)
    text = text if held else text.replace("hold top", "").replace("set top", "set other")
    state = state_at_start(tissuec.compile(text))
    state.place_held()
    return state


def parts(state):
    balance = Balance(state, ~state.held)
    matrix = balance.matrix(balance.bars(balance.start), exact=True)
    return balance, matrix, np.sin(1.0 + np.arange(len(matrix.wide)) ** 2.0)


@pytest.fixture
def iterates(monkeypatch):
    """Use iterations for nets of any size; count the solutions."""
    monkeypatch.setattr(inverses, "LARGE", 0)
    monkeypatch.setattr(inverses, "WORK", 0.0)
    return counted(monkeypatch, Iterations, "downhill")


def test_an_aggregate_of_multigrid_is_a_node_and_its_neighbours():
    """In a lattice of trilinear cells all 26 are near; nobody is left out."""
    _, matrix, _ = parts(block(2.5))
    labels = aggregates(blocks_of(matrix.sparse))
    sizes = np.bincount(labels)
    assert labels.min() == 0 and sizes.min() >= 4
    assert len(sizes) <= len(labels) / 8.0


def test_multigrid_is_symmetric_and_positive_definite():
    balance, matrix, one = parts(block(2.0))
    multigrid = Multigrid(matrix.sparse, balance.start)
    other = np.cos(one * 7.0)
    both = multigrid(one) @ other, multigrid(other) @ one
    # Rounding of sums of n numbers.
    assert both[0] == pytest.approx(both[1], rel=1e-10)
    assert one @ multigrid(one) > 0.0 and other @ multigrid(other) > 0.0


def rounds(state):
    balance, matrix, right = parts(state)
    found = Inverses(balance.start, matrix.elimination)
    Iterations(matrix, found).solve(right, 1e-8)
    return found._pace * 8.0


def test_rounds_hardly_depend_on_the_number_of_nodes():
    """Those of conjugate gradients without multigrid grow with the cells across a block."""
    small, large = rounds(block(2.0)), rounds(block(1.0))
    assert large < 20
    assert large < 1.5 * small


@pytest.mark.parametrize(
    ("box", "ratio", "most"),
    [((10, 10, 100), 0.3, 30), ((20, 20, 20), 0.49, 60), ((10, 10, 100), 0.49, 80)],
)
def test_slender_and_nearly_incompressible_bodies_converge(box, ratio, most):
    assert rounds(block(2.0, box, ratio)) < most


@pytest.mark.parametrize("ratio", [0.0, 0.3, 0.49])
def test_iterations_solve_what_a_factor_solves(ratio):
    balance, matrix, right = parts(block(2.5, ratio=ratio))
    exact = Factorization(matrix).solve(right)
    found = Iterations(matrix, balance.inverses).solve(right, 1e-12)
    # The residual times the condition of K, which is below 1e4.
    assert np.abs(found - exact).max() <= 1e-8 * np.abs(exact).max()


def test_nodes_that_only_touch_in_their_own_block_are_solved():
    """Such aggregates have no turns, which the coarser matrix must not need."""
    from scipy.sparse import csc_matrix, identity

    size = 400
    position = np.random.default_rng(1).random((size, 3))
    matrix = csc_matrix(3.0 * identity(3 * size))
    right = np.arange(3.0 * size)
    assert Multigrid(matrix, position)(right).shape == right.shape


def test_an_indefinite_matrix_is_seen():
    balance, matrix, right = parts(block(2.5))
    least = np.linalg.eigvalsh(matrix.toarray())[:2]
    below = matrix.plus(np.full(len(right), -0.5 * (least[0] + least[1])))
    kept = balance.inverses
    assert Iterations(matrix, kept).is_definite
    assert not Iterations(below, kept).is_definite
    with pytest.raises(Indefinite):
        Iterations(below, kept).solve(right)
    fresh = Inverses(balance.start, matrix.elimination)
    assert not Iterations(below, fresh).is_definite


def test_slow_iterations_end_in_a_factor(monkeypatch):
    monkeypatch.setattr(inverses, "ROUNDS", 2)
    balance, matrix, right = parts(block(4.0))
    found = Iterations(matrix, balance.inverses).solve(right)
    assert found == pytest.approx(Factorization(matrix).solve(right), rel=1e-9, abs=1e-12)


CASES = {
    "pressed": (block, (2.5,), {}, (0.0, 0.0, -3e-3)),
    "sheared, nearly incompressible": (block, (2.5,), {"ratio": 0.49}, (4e-3, 0.0, 0.0)),
    "bent by its weight": (
        block, (2.5, (5, 5, 40)), {"gravity": -3.0, "held": False}, (0.0, 0.0, 0.0),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", sorted(CASES))
def test_equilibria_are_those_of_factors(name, iterates, monkeypatch):
    make, given, more, shift = CASES[name]
    found = []
    for large in (0, 10**9):
        monkeypatch.setattr(inverses, "LARGE", large)
        state = make(*given, **more)
        top = state.held & (state.position[:, 2] > 1e-3)
        state.position[top] += shift
        iterates.clear()
        remarks = settle(state, ~state.held)
        assert bool(iterates) == (large == 0)
        found.append((state.position.copy(), remarks))
    (one, said), (other, said_too) = found
    assert said == said_too
    # Forces are balanced to 1e-12 of the largest by both; the softest motion resists 1e-4.
    assert np.abs(one - other).max() <= 1e-10


def test_a_column_buckles_by_iterations_as_by_factors(iterates, monkeypatch):
    """Pressed by 15 %, a column of 1 : 10 is unstable while it is straight."""
    found = []
    for large in (0, 10**9):
        monkeypatch.setattr(inverses, "LARGE", large)
        state = block(2.5, (5, 5, 50))
        state.position[state.held & (state.position[:, 2] > 1e-3)] += (0.0, 0.0, -7.5e-3)
        iterates.clear()
        remarks = settle(state, ~state.held)
        balance = Balance(state, ~state.held)
        assert is_firm(balance, balance.start)
        (mode,) = softest(balance, balance.start)
        found.append((remarks, np.abs(np.ptp(state.position[:, :2], axis=0)), mode.resists))
        assert bool(iterates) == (large == 0)
    (said, width, resists), (said_too, width_too, resists_too) = found
    assert [one.message for one in said] == [one.message for one in said_too] == [BUCKLED]
    # To which side is not the same, as two motions are equally soft.
    assert np.sort(width) == pytest.approx(np.sort(width_too), rel=1e-6)
    assert np.max(width) > 2 * 5e-3
    assert resists == pytest.approx(resists_too, rel=1e-4)


@pytest.mark.parametrize("aside", [0.1, 2.0])
@pytest.mark.parametrize("down", [3.0, 7.5, 10.0])
def test_a_column_whose_ends_are_apart_buckles_to_one_of_several_sides(aside, down):
    """Half a turn about y, or a mirror across y, leaves it the same until it buckles."""
    state = block(2.5, (5, 5, 50))
    before = state.position.copy()
    way = 1e-3 * np.array([aside, 0.0, -down])
    state.position[state.held & (before[:, 2] > 1e-3)] += way
    remarks = settle(state, ~state.held)
    assert [one.message for one in remarks] == [BUCKLED]
    moved, middle = state.position - before, before - before.mean(axis=0)
    unlike = []
    for signs, shift in (([-1.0, 1.0, -1.0], way), ([1.0, -1.0, 1.0], 0.0)):
        image = np.abs((signs * middle)[:, None] - middle).sum(axis=2).argmin(axis=1)
        unlike.append(np.abs(moved - signs * moved[image] - shift).max())
    assert max(unlike) > 5e-3


def test_what_the_memory_does_not_suffice_for_is_named(iterates, monkeypatch):
    monkeypatch.setattr(inverses, "ROUNDS", 2)
    monkeypatch.setattr(inverses, "MOST", 100.0)
    state = block(2.5, gravity=-3.0, held=False)
    with pytest.raises(Unsettled, match=r"conjugate gradients do not converge, and a factor"):
        settle(state, ~state.held)
