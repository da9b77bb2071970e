"""Springs that relax and yield have exact derivatives in learning."""

import numpy as np
import pytest

from tests.learn.test_fields import check_both_directions, derived, difference
from tests.learn.trials import adjust, differing, fit, moving, series, sheet
from tissuec.core.errors import CompileError
from tissuec.learn.fit.session import prepare
from tissuec.scene.request import Request

#: Two branches, and a flow that some springs begin and cease during the motion.
TISSUE = """; relaxing constant = 30 N/m; relaxation time = 8 ms
  second relaxing constant = 20 N/m; second relaxation time = 2 ms
  yield force = 20 mN; yield viscosity = 0.5 N*s/m"""
PULLED = "  from 0 s to 20 ms: move right by (2, 3, 1) mm using smooth profile"
TIMES = np.array([7e-3, 21e-3, 30e-3])
STEPS = {"velocity verlet": 1e-4, "dop853": 1e-3}


@pytest.fixture(scope="module")
def felt():
    return sheet(PULLED, tissue=TISSUE)


@pytest.mark.parametrize("name", STEPS)
def test_derivatives_of_both_directions_are_those_of_the_steps(felt, name):
    # Differences are of first order where a spring begins to yield, hence small changes.
    check_both_directions(felt, name, STEPS[name], TIMES, size=1e-5)


def test_all_numbers_have_their_derivatives(felt):
    motion, vector, weights, gradient = derived(felt, "dop853", STEPS["dop853"], TIMES)
    order, springs = motion.order, felt.network.spring_count
    first = order.places["memory"].start
    parts = {name: order.places[name] for name in ("rest", "stiffness", "damping", "position")}
    parts |= {
        f"row {row}": slice(first + row * springs, first + (row + 1) * springs)
        for row in range(order.sizes["memory"] // springs)
    }
    assert len(parts) == 4 + 2 * 2 + 2
    random = np.random.default_rng(4)
    for name, part in parts.items():
        way = np.zeros_like(vector)
        size = {"rest": 1e-6, "position": 1e-6}.get(name, 1e-5) * np.abs(vector[part]).max()
        way[part] = size * random.standard_normal(way[part].size)
        found = difference(motion, vector, way, weights)
        assert gradient @ way == pytest.approx(found, rel=1e-6), name
        assert found != 0.0, name


def test_predictions_are_those_of_the_engine_and_so_are_derivatives(felt):
    looks = [
        series(fit(felt, "position", "middle"), TIMES),
        series(fit(felt, "force", "left"), TIMES),
    ]
    adjusts = [adjust("relaxing constant", "felt"), adjust("yield force", "felt")]
    exact = moving(felt, adjusts, looks, step=1e-4)
    runs = differing(felt, adjusts, looks)
    theta = np.array([0.1, -0.05])
    found, expected = exact.predict(theta), runs.predict(theta)
    # Steps do not end where springs begin to yield, which leaves errors of second order.
    assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()
    slopes, rough = exact.jacobian(theta), runs.jacobian(theta)
    # Derivatives jump there, between steps as well as between runs.
    assert np.abs(slopes - rough).max() < 2e-3 * np.abs(rough).max()


def test_an_implicit_method_is_refused(tmp_path):
    (tmp_path / "data.csv").write_text("t,x\n0.01,1\n0.02,2\n0.03,3\n")
    learn = """learn felt { data = "data.csv"; time using column "t" in s
  fit = position(middle) along (1, 0, 0) using column "x" in mm
  adjust relaxing constant of felt; integrator is esdirk43 }"""
    file = tmp_path / "sheet.tis"
    compiled = sheet(PULLED, tissue=TISSUE, file=file, sets=learn)
    with pytest.raises(CompileError, match="esdirk43 does not support springs that relax"):
        prepare(compiled, compiled.fit_problems[0], Request.file(file))
