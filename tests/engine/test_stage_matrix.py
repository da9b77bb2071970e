"""The matrix of implicit steps with all that a scene has, against differences of the forces."""

import numpy as np
import pytest

from tests.engine.running import accelerated
from tests.every import every
from tests.validate.scenes import compiled_scene
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.engine.kernel_inputs import KernelInputs
from tissuec.engine.stage_matrix import StageMatrix
from tissuec.mechanics.stiffness import PRECISION

SCENE = """language 1
tissue gel {{
  Young's modulus = 10 kPa; Poisson's ratio = {poisson}; density = 1000 kg/m^3; {memory}
}}
tissue cord {{
  spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 5 mg; {cord}
}}
body piece {{ mesh is {mesh}; tissue is {tissue}; {body} }}
set near = nodes of piece where x < 0.1 mm
environment {{ gravity = (0, 0, 0) m/s^2; contact is off; damping = 1 mN*s/m; {planes} }}
{force}
script {{ at 0 s: {{ fix near; {script} }} }}
simulate {{ duration = 10 ms }}
"""
BLOCK = "lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 5, 5) mm }"
SHEET = (
    "sheet { corner = (0, 0, 0) mm; first edge = (10, 0, 0) mm; "
    "second edge = (0, 10, 0) mm; columns = 3; rows = 3 }"
)
WALL = "made of elements; thickness = 1 mm"
RELAXING = "relaxing share = 0.4; relaxation time = 2 ms"
TWICE = f"{RELAXING}; second relaxing share = 0.2; second relaxation time = 50 ms"
YIELDING = "yield stress = 100 Pa; flow viscosity = 5 Pa*s"
NET = BLOCK.replace("lattice {", "lattice { kind is sodium chloride;")
SPRINGS = {"mesh": NET, "tissue": "cord", "body": ""}
RELAXES = "relaxing constant = 30 N/m; relaxation time = 2 ms"
PLANE = "symmetric about plane through (0, 0, 0) mm facing (0, -1, 0)"
BALL = "sphere { centre = (5, 0, 0) mm; radius = 5.01 mm; subdivisions = 1 }"
CASES = {
    "a damped solid": {"memory": "retardation time = 3 ms"},
    "a solid that hardly changes its volume": {"poisson": "0.49"},
    "a solid that relaxes": {"memory": f"retardation time = 3 ms; {TWICE}"},
    "a solid that yields": {"memory": f"retardation time = 3 ms; {YIELDING}"},
    "a solid that relaxes and yields": {
        "memory": f"{TWICE}; {YIELDING}; solid law is mooney rivlin {{ share = 0.4 }}"},
    "a wall that relaxes": {"mesh": SHEET, "body": WALL, "memory": TWICE},
    "a wall": {"mesh": SHEET, "body": WALL, "memory": "retardation time = 3 ms"},
    "springs that relax": SPRINGS | {"cord": RELAXES},
    "springs that relax and yield": SPRINGS | {
        "cord": f"{RELAXES}; yield force = 1 uN; yield viscosity = 1 N*s/m"},
    "springs with a law": SPRINGS | {"cord": "spring law is exponential { stiffening = 3 }",
                                     "script": "preserve volume of piece with gentle pressure"},
    "a volume": {"mesh": BALL, "tissue": "cord", "body": "",
                 "script": "preserve volume of piece with 2 kPa"},
    "a foundation": {"force": "force bed { kind is foundation; acts on piece; "
                              "stiffness = 1 MPa/m; damping = 3 kPa*s/m }"},
    "a ball under pressure": {"mesh": BALL, "body": WALL, "script": "press piece with 0.1 kPa"},
    "a symmetric half": {"memory": f"retardation time = 3 ms; {RELAXING}",
                         "planes": PLANE},
}  # fmt: skip
REST = {"memory": "", "poisson": "0.3", "cord": "", "mesh": BLOCK, "tissue": "gel",
        "body": "", "planes": "", "force": "", "script": ""}  # fmt: skip


def moved_state(case):
    """Return a state in which all free nodes are somewhere else, with what it remembers."""
    state = state_at_start(compiled_scene(SCENE.format(**REST | CASES[case])))
    random = np.random.default_rng(3)
    # Stretched, since what is pressed makes the whole derivative indefinite.
    shift = 0.05e-3 * random.normal(size=state.position.shape) + 0.1 * state.position
    shift *= 0.02 if "0.49" in CASES[case].get("poisson", "") else 1.0
    if state.guides is not None:
        shift[state.guides.nodes, 1] = 0.0
    state.position += np.where(state.held[:, None], 0.0, shift)
    memory = state.network.internal_rows
    state.velocity[memory] = 0.02 * random.normal(size=state.velocity[memory].shape)
    return state


def unknowns(state):
    """Return the components of free nodes and of what is remembered, ascending."""
    rows = state.network.row_count - state.network.node_count
    free = np.append(~state.held, np.ones(rows, dtype=bool))
    found = np.repeat(free, 3)
    if state.guides is not None:
        found[3 * state.guides.nodes + 1] = False
    return np.flatnonzero(found)


def by_differences(state, q, along):
    """Return (1 - q ∂a/∂v - q² ∂a/∂x) times a direction, by differences, shape (node, 3).

    Args:
        along: Of nodes and of what is remembered, shape (node + row, 3).
    """
    found = along.copy()
    moved = along[: state.network.node_count]
    for part, factor, way, step in (
        (state.velocity, q, along, 1e-5),
        (state.position, q * q, moved, 1e-8),
    ):
        step /= np.abs(way).max()
        kept, ends = part.copy(), []
        for sign in (1.0, -1.0):
            part[:] = kept + sign * step * way
            ends.append(accelerated(state)[0])
        part[:] = kept
        found -= factor * (ends[0] - ends[1]) / (2.0 * step)
    return found


def solved(state, q, residual):
    """Return what the matrix makes of residuals of all nodes, shape (node, 3)."""
    inputs = KernelInputs(state.network, watched=False, ledger=False)
    inputs.update(state)
    solver, net = inputs.solver(), None
    x, v = inputs.inwards(state.position), inputs.inwards(state.velocity)
    assert inputs.stage.assemble(q, x, v, net, solver)
    vector = inputs.inwards(residual)
    assert inputs.stage.solve(vector, net, solver)
    return inputs.outwards(vector)


def residuals(state, seed=1):
    flat = np.zeros(state.velocity.size)
    chosen = unknowns(state)
    flat[chosen] = np.random.default_rng(seed).normal(size=len(chosen))
    return flat.reshape(-1, 3)


@every("case", CASES)
def test_newtons_method_has_the_whole_derivative(case):
    # A shorter step than 1.5 ms is needed: masses of few cells leave it definite until then.
    state, q = moved_state(case), 1.3e-3
    residual = residuals(state)
    found = solved(state, q, residual)
    chosen = unknowns(state)
    assert np.isin(np.flatnonzero(found), chosen).all()
    made = by_differences(state, q, found).reshape(-1)
    # Hidden nodes have three components also where fewer are needed.
    along = residuals(state, 2)
    used = by_differences(state, q, along).reshape(-1)[chosen] != along.reshape(-1)[chosen]
    off = (made - residual.reshape(-1))[chosen]
    assert np.abs(off)[used].max() < 2e-6 * np.abs(residual).max()
    # Without the forces, the answer would be another one.
    apart = (found - residual).reshape(-1)[chosen]
    assert np.abs(apart).max() > 0.05 * np.abs(found).max()


def test_where_it_is_not_definite_the_negative_parts_are_left_out():
    state = moved_state("a damped solid")
    x = state.position[:, 0]
    state.position[:, 0] -= 0.75 * np.where(state.held, 0.0, x)  # pressed to a quarter
    exacts, own = [], StageMatrix._matrix

    def counted(matrix, *arguments, exact, relaxes):
        exacts.append(exact)
        return own(matrix, *arguments, exact=exact, relaxes=relaxes)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(StageMatrix, "_matrix", counted)
        found = solved(state, 1.0, residuals(state))
    assert exacts == [True, False]
    assert np.isfinite(found).all()


def test_no_numbers_have_no_matrix():
    for size in (np.nan, 1e200):
        state = moved_state("a solid that relaxes")
        state.position[~state.held] *= size
        inputs = KernelInputs(state.network, watched=False, ledger=False)
        inputs.update(state)
        x, v = inputs.inwards(state.position), inputs.inwards(state.velocity)
        solver = inputs.solver()
        assert not inputs.stage.assemble(1e-3, x, v, None, solver)


@pytest.mark.parametrize("case", ["a damped solid", "a volume", "a solid that relaxes"])
def test_conjugate_gradients_solve_where_a_factor_would_be_too_large(case, monkeypatch):
    state = moved_state(case)
    residual = residuals(state)
    direct = solved(state, 1e-3, residual)
    monkeypatch.setattr("tissuec.engine.unknowns.LARGEST_WORK", 0.0)
    iterated = solved(state, 1e-3, residual)
    assert np.abs(iterated - direct).max() < 30.0 * PRECISION * np.abs(direct).max()
    assert not np.array_equal(iterated, direct)


def test_the_fill_is_that_of_the_factor():
    mesh = "lattice { cell = 5 mm; box from (0, 0, 0) mm to (30, 25, 20) mm }"
    text = SCENE.format(**REST | {"mesh": mesh})
    state = state_at_start(compiled_scene(text))
    inputs = KernelInputs(state.network, watched=False, ledger=False)
    inputs.update(state)
    solver = inputs.solver()
    x, v = inputs.inwards(state.position), inputs.inwards(state.velocity)
    assert inputs.is_direct()
    assert inputs.stage.assemble(1e-3, x, v, None, solver)
    factor = inputs.stage._factor._pivoted._factor
    numbers = factor.L.nnz + factor.U.nnz
    assert inputs.stage.fill.numbers == pytest.approx(numbers, rel=0.25)
    columns = np.diff(factor.L.indptr).astype(float)
    assert inputs.stage.fill.multiplications == pytest.approx((columns**2).sum(), rel=0.5)
