"""What is predicted of a net at rest, and its derivatives, against closed forms."""

from math import exp

import numpy as np
import pytest
from scipy.optimize import least_squares

from tissuec.core.errors import CompileError
from tissuec.engine.execution.run import run
from tissuec.learn.derivatives import finite_differences
from tissuec.learn.derivatives.finite_differences import FiniteDifferenceModel
from tissuec.learn.derivatives.motion import Diverged
from tissuec.learn.derivatives.observables import look_of
from tissuec.learn.derivatives.static_model import StaticModel
from tissuec.learn.fit import expense
from tissuec.learn.fit.expense import expense_of
from tissuec.learn.fit.learning import learn
from tissuec.learn.fit.problem import FittedExperiment, Problem
from tissuec.learn.fit.search import Search
from tissuec.learn.fit.session import prepare
from tissuec.learn.parameters.parametrisation import Parametrisation
from tissuec.measurements.reading import read_experiment
from tissuec.pipeline import compile_request
from tissuec.scene.program.imports import read_source
from tissuec.scene.request import Request

C, SPRINGS, LENGTH, MASS, G = 40.0, 4, 0.01, 1e-5, 9.81
HELD = "at 0 s: fix left"
PULLED = f"{HELD}\nfrom 0 s to 1 s: move right by (4, 0, 0) mm using smooth profile"
FORCE = 'fit = force(right) along (1, 0, 0) using column "f" in N'
DISPLACED = 'displacement of right using column "u" in mm'


def chain(script, learn, *, law="", body="", gravity=0.0):
    """Return a scene of springs in a row along x, 10 mm each."""
    rows = "; ".join(f"{k} {10 * k}" for k in range(SPRINGS + 1))
    pairs = "; ".join(f"{k} {k + 1}" for k in range(SPRINGS))
    return f"""language 1
tissue gum {{ spring constant = {C} N/m; viscosity = 1 mN*s/m; mass = 10 mg {law} }}
body cord {{ mesh is explicit; tissue is gum; {body} }}
table nodes of cord in mm with columns "id x" {{ {rows} }}
table springs of cord with columns "a b" {{ {pairs} }}
set left = nodes of cord in [0]
set right = nodes of cord in [{SPRINGS}]
set inner = nodes of cord in [2]
set lost = nodes of cord in [0, 1]
environment {{ gravity = ({gravity}, 0, 0) m/s^2 }}
script {{ {script} }}
simulate {{ duration = 1 s }}
learn gum {{ data = "data.csv"; {learn} }}
"""


@pytest.fixture
def model(tmp_path):
    """Return a function that makes the model and the problem of a scene and its data."""

    def make(text, table):
        (tmp_path / "data.csv").write_text(table, encoding="utf-8")
        path = tmp_path / "scene.tis"
        path.write_text(text, encoding="utf-8")
        compiled, _ = compile_request(Request(read_source(path, "scene.tis")))
        (fit_problem,) = compiled.fit_problems
        experiment = read_experiment(fit_problem.data[0], fit_problem, compiled.network)
        shaping = Parametrisation(compiled, fit_problem)
        looks = tuple(look_of(one.fit, one.nodes) for one in experiment.series)
        found = StaticModel(shaping, experiment.series, looks, fit_problem.axis)
        found.freeze(np.zeros(shaping.size))
        return found, Problem(
            fit_problem, [FittedExperiment(experiment, found)], shaping.size, []
        )

    return make


def csv(displacements, values=None):
    """Return a table of displacements in mm and of values, beside columns of zeros."""
    values = range(len(displacements)) if values is None else values  # none is constant
    pairs = zip(displacements, values, strict=True)
    return "\n".join(["u,f,g,h", *(f"{float(u)!r},{float(f)!r},0,0" for u, f in pairs)]) + "\n"


def differences(model, theta, step=1e-3):
    """Return the derivatives of predictions by central differences of fourth order."""
    columns = []
    for way in np.eye(len(theta)):
        ahead, behind, far, back = (
            model.predict(theta + s * step * way) for s in (1.0, -1.0, 2.0, -2.0)
        )
        columns.append((8.0 * (ahead - behind) - (far - back)) / (12.0 * step))
    return np.array(columns).T


def assert_derived(model, theta):
    """Compare the derivatives with differences and with each other."""
    exact, rough = model.jacobian(theta), differences(model, theta)
    size = np.abs(exact).max(axis=0)
    assert (size[:4] > 1e-5).all()  # where free nodes begin, a net at rest has forgotten
    # Differences of fourth order with a step of 1e-3, of equilibria that are known to 1e-14 m.
    assert (np.abs(exact - rough).max(axis=0) < 1e-7 * size + 1e-11).all()
    weights = np.random.default_rng(3).standard_normal(model.size)
    forwards = exact.T @ weights
    # Both are exact; rounding is amplified by how soft the softest motion is.
    assert model.gradient(theta, weights) == pytest.approx(
        forwards, rel=1e-10, abs=1e-10 * np.abs(forwards).max()
    )


# --- closed forms -----------------------------------------------------------------------------


def test_springs_in_a_row_share_the_stretch(model):
    u = np.array([0.0, 0.5, 1.0, 2.5, 4.0])
    found, _ = model(
        chain(PULLED, f"{DISPLACED}; {FORCE}; adjust spring constant of gum"), csv(u)
    )
    force = C * 1e-3 * u / SPRINGS
    # Displacements are found to rounding of places, some 1e-17 m.
    assert found.predict(np.zeros(1)) == pytest.approx(force, rel=1e-11, abs=1e-14)
    # The parameter is a logarithm, and force is proportional to the constant.
    assert found.jacobian(np.zeros(1))[:, 0] == pytest.approx(force, rel=1e-9, abs=1e-12)


def test_a_hanging_chain_gets_longer_by_its_mass(model):
    def length(theta):
        # Of n springs, the k-th from below bears k nodes; the last node hangs free.
        n, mass = SPRINGS, MASS * np.exp(theta)
        return n * LENGTH + mass * G / C * n * (n + 1) / 2

    script = f"{HELD}\nfrom 0 s to 1 s: move left by (4, 0, 0) mm using constant speed"
    text = chain(
        script.replace("at 0 s: fix left", ""),
        'displacement of left using column "u" in mm\n'
        'fit = position(right) along (1, 0, 0) using column "f" in m\nadjust mass of gum',
        gravity=G,
    )
    found, _ = model(text, csv([0.0, 3.0]))
    for theta in (0.0, 0.7):
        at = np.array([theta])
        moved = np.array([0.0, 3e-3])
        # Springs balance to 1e-12 of the weight.
        assert found.predict(at) == pytest.approx(moved + length(theta), rel=1e-11)
        slope = length(theta) - SPRINGS * LENGTH
        assert found.jacobian(at)[:, 0] == pytest.approx([slope, slope], rel=1e-9)
        assert found.gradient(at, np.array([1.0, -3.0])) == pytest.approx(
            [-2.0 * slope], rel=1e-9
        )


def test_the_constant_of_a_law_is_found_in_a_curve(model):
    u, k, c = np.linspace(0.0, 4.0, 5), 5.0, 55.0
    strain = 1e-3 * u / SPRINGS / LENGTH
    text = chain(
        PULLED,
        f"{DISPLACED}; {FORCE}; adjust spring constant of gum; adjust stiffening of gum",
        law="; spring law is exponential { stiffening = 3 }",
    )
    force = [c * LENGTH / k * (exp(k * s) - 1.0) for s in strain]
    found, problem = model(text, csv(u, force))
    shaping = found.shaping
    search = Search(problem, shaping.bounds(), lambda _: None)
    end = search.go(search.begin())
    values = [shaping.blocks[n].value(end.theta[shaping.place(n)])[0] for n in range(2)]
    # Data is exact, and the fit problem ends at its own tolerance of the error.
    assert values == pytest.approx([c, k], rel=1e-6)


def test_the_curve_without_a_problem(model):
    u, k = np.linspace(0.5, 4.0, 5), 2.0
    text = chain(
        PULLED, f"{DISPLACED}; {FORCE}; adjust stiffening of gum",
        law="; spring law is exponential { stiffening = 3 }",
    )  # fmt: skip
    force = [C * LENGTH / k * (exp(k * s) - 1.0) for s in 1e-3 * u / SPRINGS / LENGTH]
    found, _ = model(text, csv(u, force))
    data = np.array(force)
    end = least_squares(lambda t: (found.predict(t) - data) * 1e3, [0.0],
                        lambda t: 1e3 * found.jacobian(t), xtol=1e-15, gtol=1e-15)  # fmt: skip
    assert found.shaping.blocks[0].value(end.x) == pytest.approx([k], rel=1e-7)


# --- derivatives ------------------------------------------------------------------------------

NET = """language 1
tissue gum { spring constant = 40 N/m; viscosity = 1 mN*s/m; mass = 10 mg; prestress = 2 %
  spring law is exponential { stiffening = 3 } }
body block {
  mesh is lattice { kind is sodium chloride; cell = 10 mm; reach is second neighbours
    box from (0, 0, 0) mm to (30, 10, 10) mm }
  tissue is gum
}
set left = nodes of block where x < 1 mm
set right = nodes of block where x > 29 mm
set inner = nodes of block where x between 9 mm and 11 mm
set edge = nodes of block where x between 19 mm and 21 mm and z > 9 mm
environment { gravity = (0, 0, -9.81) m/s^2 }
simulate { duration = 1 s }
"""
MOVED = "from 0 s to 1 s: move right by (3, 0, 1) mm using smooth profile"
FITS = """data = "data.csv"; displacement of right using column "u" in mm
fit = force(right) using columns "f g h" in N
fit = force(left) using column "f" in N
fit = position(inner) along (0, 0, 1) using column "f" in mm
fit = distance(left, inner) using column "f" in mm
fit = length(block) using column "f" in mm
"""
EVERYTHING = """adjust spring constant of gum; adjust mass of gum; adjust stiffening of gum
adjust prestress of gum; adjust start position of inner along (0, 0, 1)
adjust start position of left along (1, 0, 0); adjust start position of right"""


#: Displacements [mm] before, between and behind what happens.
BETWEEN = (0.3, 1.7, 1.7, 3.0)


@pytest.mark.parametrize(
    ("script", "rows"),
    [
        pytest.param(f"at 0 s: fix left\n{MOVED}", BETWEEN, marks=pytest.mark.slow),
        (f"at 0 s: fix left\nat 0.4 s: fix edge\n{MOVED}\nat 0.7 s: free edge", BETWEEN),
        (
            "at 0 s: fix left\n"
            "from 0 s to 1 s: push edge with 0.02 N along (0, 1, 0) using ramp\n"
            f"at 0.3 s: change spring constant of block by 150 %\n{MOVED}\n"
            "at 0.5 s: cut block along plane through (15, 0, 5) mm facing (1, 0, 0)".replace(
                "cut block along plane", "cut block along stroke"
            ).replace(
                "through (15, 0, 5) mm facing (1, 0, 0)",
                "from (15, 0, 5) mm to (15, 10, 5) mm by (0, 0, 9) mm",
            ),
            BETWEEN,
        ),
        (f"at 0 s: fix left\nat 0 s: settle\nat 0 s: fix edge\n{MOVED}", (0.3, 3.0)),
    ],
    ids=["moved", "held on the way", "pushed, changed and cut", "settled and held"],
)
def test_derivatives_are_those_of_the_predictions(model, script, rows):
    text = NET + f"script {{ {script} }}\nlearn gum {{ {FITS} {EVERYTHING} }}\n"
    found, _ = model(text, csv(rows))
    assert_derived(found, 0.05 * np.random.default_rng(1).standard_normal(found.shaping.size))


def test_numbers_of_single_springs_and_nodes_have_derivatives(model):
    more = """adjust spring constant of block per spring; adjust mass of inner per node
adjust rest length of block per spring"""
    text = NET + f"script {{ at 0 s: fix left\n{MOVED} }}\nlearn gum {{ {FITS} {more} }}\n"
    found, _ = model(text, csv([1.0, 3.0]))
    theta = np.zeros(found.shaping.size)
    exact, step = found.jacobian(theta), 1e-3
    for way in np.random.default_rng(2).standard_normal((3, len(theta))) / len(theta) ** 0.5:
        rough = sum(
            w * found.predict(theta + s * step * way)
            for s, w in ((1.0, 8.0), (-1.0, -8.0), (2.0, -1.0), (-2.0, 1.0))
        ) / (12.0 * step)
        assert exact @ way == pytest.approx(rough, rel=1e-7, abs=1e-7 * np.abs(rough).max())
    weights = np.random.default_rng(3).standard_normal(found.size)
    both = found.gradient(theta, weights), exact.T @ weights
    assert both[0] == pytest.approx(both[1], rel=1e-10, abs=1e-10 * np.abs(both[1]).max())


# --- rows and the script ----------------------------------------------------------------------


def forces(model, script, displacements, **scene):
    """Return what is predicted of the force at the moved end of a chain [N]."""
    learn = f"{DISPLACED}; {FORCE}; adjust spring constant of gum"
    found, _ = model(chain(script, learn, **scene), csv(displacements))
    return found.predict(np.zeros(1)), found


def test_equal_rows_share_one_equilibrium(model):
    found, resting = forces(model, PULLED, [0.0, 1.0, 1.0, 4.0, 4.0])
    assert len(resting._stands) == 3
    assert found[1] == found[2]
    assert found[3:] == pytest.approx([C * 4e-3 / SPRINGS] * 2, rel=1e-11)


def test_what_is_cut_pulls_no_more(model):
    script = PULLED + "\nat 0.5 s: cut cord along plane through (15, 0, 0) mm facing (1, 0, 0)"
    found, resting = forces(model, script, [1.0, 1.9, 2.1, 4.0])
    # Half of the time is half of the way.
    assert found[:2] == pytest.approx(C * 1e-3 * np.array([1.0, 1.9]) / SPRINGS, rel=1e-11)
    assert found[2:] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert resting.jacobian(np.zeros(1))[:, 0] == pytest.approx(found, rel=1e-9, abs=1e-12)
    assert any("mechanism" in note for note in resting.notes)


def test_what_bears_too_much_breaks_and_stays_broken(model):
    # Half of the greatest force.
    weak = {"law": "; breaking force = 0.02 N", "body": "rupture is allowed"}
    found, _ = forces(model, PULLED, [1.0, 1.9, 2.1, 4.0], **weak)
    assert found[:2] == pytest.approx(C * 1e-3 * np.array([1.0, 1.9]) / SPRINGS, rel=1e-11)
    assert found[2:] == pytest.approx([0.0, 0.0], abs=1e-12)


@pytest.mark.parametrize(
    "script",
    [
        "from 0.2 s to 0.5 s: move right by (0, 0, 4) mm using smooth profile\n"
        "from 0.6 s to 1 s: move right by (0, 0, -4) mm using constant speed",
        "from 0 s to 1 s: move right by (0, 0, 4) mm using sine of 0.75 Hz",
        "from 0 s to 0.5 s: move right by (0, 0, 4) mm using constant speed\n"
        "at 0.5 s: release right",
    ],
    ids=["there and back", "a sine", "let go of"],
)
def test_rows_lie_on_the_first_way_out(model, script):
    script, u = f"{HELD}\n{script}", np.array([0.5, 2.0, 4.0])
    learn = (
        f'{DISPLACED}; fit = position(right) using columns "f g h" in mm; adjust mass of gum'
    )
    found, _ = model(chain(script, learn), csv(u))
    places = found.predict(np.zeros(1)).reshape(-1, 3)
    # Places are known to rounding, some 1e-17 m; the top of a sine to its square root.
    assert places[:, 2] == pytest.approx(1e-3 * u, rel=1e-12)
    assert places[:, :2] == pytest.approx(np.tile([4 * LENGTH, 0.0], (3, 1)), abs=1e-15)


def test_no_displacement_is_when_the_nodes_set_out(model):
    script = PULLED.replace("from 0 s", "from 0.4 s") + "\nat 0 s: fix right"
    push = "at 0.3 s: push inner with 0.01 N along (1, 0, 0)"
    free, _ = forces(model, script, [0.0, 4.0], law="; prestress = 20 %")
    pushed, _ = forces(model, f"{script}\n{push}", [0.0, 4.0], law="; prestress = 20 %")
    # Either end bears half of what acts in the middle.
    assert pushed - free == pytest.approx([-0.005, -0.005], rel=1e-9)


@pytest.mark.parametrize(("u", "told"), [(4.5, "4.5 mm"), (-1.0, "-1 mm")])
def test_a_row_beyond_the_motion_is_refused(model, u, told):
    with pytest.raises(CompileError, match="TIS703") as caught:
        forces(model, PULLED, [u, 1.0])
    assert told in str(caught.value)
    assert "from 0 m to 4 mm" in str(caught.value)


@pytest.mark.parametrize("least", [-4.0, 0.0])
def test_tension_and_compression_have_a_sign_along_a_line(model, least):
    """All nodes but the held one are moved, so that nothing buckles: one spring resists."""
    to_and_fro = """at 0 s: fix left
from 0 s to 0.4 s: move inner by (2, 0, 0) mm using constant speed
from 0.4 s to 1 s: move inner by (-6, 0, 0) mm using constant speed"""
    signed = DISPLACED.replace("of right", "of inner along (1, 0, 0)")
    force = FORCE.replace("force(right)", "force(left)")
    u = np.linspace(least, 2.0, 5)
    text = chain(to_and_fro, f"{signed}; {force}; adjust spring constant of gum")
    found, _ = model(text.replace("cord in [2]", "cord in [1, 2, 3, 4]"), csv(u))
    expected = -C * 1e-3 * u
    assert found.predict(np.zeros(1)) == pytest.approx(expected, rel=1e-11, abs=1e-13)
    assert found.jacobian(np.zeros(1))[:, 0] == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_a_negative_displacement_without_a_line_is_refused_with_the_way_out(model):
    with pytest.raises(CompileError) as refused:
        model(chain(PULLED, f"{DISPLACED}; {FORCE}; adjust spring constant of gum"), csv([-1]))
    assert "displacement of SET along (1, 0, 0)" in refused.value.diagnostics[0].hint


def test_nodes_that_nothing_moves_are_refused(model):
    with pytest.raises(CompileError, match="TIS703"):
        forces(model, f"{HELD}\nat 0 s: fix right", [0.0])


def test_what_has_no_exact_derivatives_is_fitted_by_differences(tmp_path):
    """Springs in a row share the stretch, as where there are exact derivatives."""
    u = np.array([0.0, 1.0, 2.5])
    (tmp_path / "data.csv").write_text(csv(u))
    path = tmp_path / "scene.tis"
    script = f"{PULLED}\nwhen force(right) > 1 N: release right"
    path.write_text(chain(script, f"{DISPLACED}; {FORCE}; adjust spring constant of gum"))
    request = Request.file(path)
    compiled, _ = compile_request(request)
    (trial,) = prepare(compiled, compiled.fit_problems[0], request).learning
    assert isinstance(trial.model, FiniteDifferenceModel)
    assert "the script waits for a condition" in trial.model.notes[0]
    force = C * 1e-3 * u / SPRINGS
    # Equilibria are found to 1e-9; differences are wrong by the square of a step of 1.4e-3.
    assert trial.model.predict(np.zeros(1)) == pytest.approx(force, rel=1e-8, abs=1e-11)
    assert trial.model.jacobian(np.zeros(1))[:, 0] == pytest.approx(force, rel=1e-5, abs=1e-9)


def test_the_number_of_runs_is_told_before_a_fit_by_differences(tmp_path, monkeypatch):
    u = np.array([0.0, 1.0, 2.5])
    (tmp_path / "data.csv").write_text(csv(u, 1.3 * C * 1e-3 * u / SPRINGS))
    path = tmp_path / "scene.tis"
    script = f"{PULLED}\nwhen force(right) > 1 N: release right"
    path.write_text(chain(script, f"{DISPLACED}; {FORCE}; adjust spring constant of gum"))
    request = Request.file(path)
    compiled, _ = compile_request(request)
    session = prepare(compiled, compiled.fit_problems[0], request)
    count = 0

    def counting(*arguments):
        nonlocal count
        count += 1
        return run(*arguments)

    monkeypatch.setattr(finite_differences, "run", counting)
    learn(compiled, compiled.fit_problems[0], request, session=session)
    expected = expense_of(session)
    # A good start needs half as many runs, a bad one twice as many.
    assert 0.4 * expected.runs < count < 2.5 * expected.runs
    assert 0.0 < expected.seconds < 10.0
    assert not expected.announcement
    monkeypatch.setattr(expense, "MANY", 20)
    text = "derivatives are finite differences, which take about 20 runs, 3 s of processor time"
    assert expense_of(session).announcement == text


def test_a_net_that_nothing_holds_has_no_equilibrium(model):
    script = "from 0 s to 1 s: move right by (4, 0, 0) mm using smooth profile\n"
    script += "at 0.5 s: cut cord along plane through (15, 0, 0) mm facing (1, 0, 0)"
    with pytest.raises(Diverged, match=r"at .* of the script, .* node") as caught:
        forces(model, script, [0.0, 4.0], gravity=-G)
    assert caught.value.args[0] == pytest.approx(1.0, abs=1e-3)


def test_a_piece_that_floats_falls_when_it_gets_heavier(model):
    # Each node of it is pushed up by its weight, to rounding.
    script = f"""at 0 s: cut cord along plane through (15, 0, 0) mm facing (1, 0, 0)
at 0 s: push lost with {MASS * G!r} N on each node along (1, 0, 0)
from 0 s to 1 s: move right by (4, 0, 0) mm using smooth profile"""
    learn = f"{DISPLACED}; {FORCE}; adjust mass of gum"
    found, _ = model(chain(script, learn, gravity=-G), csv([0.0, 4.0]))
    # Three nodes hang from the moved one.
    assert found.predict(np.zeros(1)) == pytest.approx([2 * MASS * G] * 2, rel=1e-9)
    told = "at a displacement of 0 m node [01] can move along the forces "
    for derive in (found.jacobian, lambda theta: found.gradient(theta, np.ones(2))):
        with pytest.raises(Diverged, match=told):
            derive(np.zeros(1))


def test_what_nothing_resists_stays_where_it_is(model):
    # Without tension nothing resists across the chain, and there its end is brought.
    learn = f"""{DISPLACED}; fit = position(inner) using columns "f g h" in mm
adjust start position of right; adjust spring constant of gum"""
    found, _ = model(chain(PULLED, learn), csv([0.0, 4.0]))
    slopes = found.jacobian(np.zeros(4)).reshape(2, 3, 4)
    along, across = np.array([0.5, 0.0, 0.0]), np.array([0.0, 0.5, 0.0])
    scale = found.shaping.blocks[0].scale
    # The middle follows half of the way, but only where there is tension.
    assert slopes[:, 0, :3] == pytest.approx(scale * np.array([along, along]), abs=1e-9)
    assert slopes[:, 1, :3] == pytest.approx(scale * np.array([0 * across, across]), abs=1e-9)
    weights = np.arange(1.0, 7.0)
    assert found.gradient(np.zeros(4), weights) == pytest.approx(
        np.tensordot(weights, slopes.reshape(6, 4), 1), rel=1e-12
    )


def test_buckling_is_noted(model):
    script = f"{HELD}\nfrom 0 s to 1 s: move right by (-2, 0, 0) mm using smooth profile"
    _, resting = forces(model, script, [0.0, 2.0])
    assert any(
        note.startswith("at a displacement of") and "buckled" in note for note in resting.notes
    )
