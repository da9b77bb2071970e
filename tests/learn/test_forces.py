"""Numbers of ``force`` blocks are learnt, exactly where their fields have derivatives."""

import numpy as np
import pytest

import tissuec
from tests.learn.trials import adjust, differing, fit, moving, series
from tissuec.core.source import Source
from tissuec.core.structs import replace
from tissuec.forces.acting.foundation import Bed
from tissuec.learn.derivatives.refusals import refusal
from tissuec.learn.fit.learning import learn
from tissuec.learn.presets.preset import compose, place
from tissuec.pipeline import check_request, compile_request, read_words
from tissuec.scene.request import Request

SHEET = """language 1
param ground = {ground}
tissue wall {{ spring constant = 28 N/m; density = 1000 kg/m^3; retardation time = 1 ms }}
body sheet {{ tissue is wall; thickness = 1 mm
  mesh is sheet {{ corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm
    second edge = (0, 10, 0) mm; columns = 4; rows = 2; diagonals is both }} }}
set pulled = nodes of sheet where x > 19 mm
force bed {{ kind is foundation; acts on sheet; stiffness = ground; {damping} }}
environment {{ gravity = (0, 0, -9.81) m/s^2 }}
script {{ from 0 s to 10 ms: move pulled by (2, 0, 3) mm using smooth profile }}
simulate {{ duration = 20 ms; tolerance = 1e-8 }}
output {{ trajectory every 2 ms; force of pulled every 2 ms }}
{more}
"""
DAMPED = "damping = 200 Pa*s/m"
LEARN = """learn {name} {{ data = "truth.vtkhdf"
  fit = force(pulled); fit = positions(sheet); {adjust}
  write "learned.tis" }}"""


def scene(more="", *, ground="50 kPa/m", damping=DAMPED):
    text = SHEET.format(ground=ground, damping=damping, more=more)
    return compile_request(Request(Source("sheet.tis", text)))[0]


@pytest.fixture
def sheet(tmp_path):
    """Return a function that writes a scene that learns from a run of a stiffer one."""

    def write(adjust, *, name="bed", damping="damping = 150 Pa*s/m"):
        path = tmp_path / "sheet.tis"
        more = LEARN.format(name=name, adjust=adjust)
        path.write_text(SHEET.format(ground="50 kPa/m", damping=damping, more=more))
        return path

    return write


def truth(path):
    text = SHEET.format(ground="120 kPa/m", damping=DAMPED, more="")
    (path.parent / "truth.tis").write_text(text)
    tissuec.run(path.parent / "truth.tis", out=path.parent / "truth.vtkhdf", companion="off")


def test_a_foundation_is_found_from_a_run_of_it(sheet):
    path = sheet("adjust = [stiffness, damping]")
    truth(path)
    request = Request.file(path)
    compiled, _ = compile_request(request)
    (fit_problem,) = compiled.fit_problems
    learnt = learn(compiled, fit_problem, request)
    assert "exact derivatives of every step" in learnt.method
    found = [float(one.value[0]) for one in learnt.estimates]
    assert found == pytest.approx([120e3, 200.0], rel=1e-6)
    place(compose(learnt, compiled, request, fit_problem.write), force=False)
    # The preset declares params, and is right by itself.
    preset = Request.file(fit_problem.write, strict=True)
    assert check_request(preset) == (None, ())
    constants = read_words(preset)[0].constants.parameters()
    assert {one.name: float(one.value.amount) for one in constants} == pytest.approx(
        {"learned bed stiffness": 120e3, "learned bed damping": 200.0}, rel=1e-6
    )


def adjusts(*names):
    return [replace(adjust(name, "bed"), per="force") for name in names]


def looks(compiled):
    times = np.array([5e-3, 12e-3, 20e-3])
    return [series(fit(compiled, name, "pulled"), times) for name in ("force", "position")]


def test_derivatives_are_those_of_whole_runs():
    compiled = scene()
    many, seen = adjusts("stiffness", "damping"), looks(compiled)
    theta = np.array([0.1, -0.2])
    exact, runs = (make(compiled, many, seen) for make in (moving, differing))
    assert exact.predict(theta) == pytest.approx(runs.predict(theta), rel=1e-6, abs=1e-9)
    rows, expected = exact.jacobian(theta), runs.jacobian(theta)
    assert np.abs(rows - expected).max(axis=0) == pytest.approx(
        0.0, abs=1e-3 * np.abs(expected).max(axis=0).min()
    )
    step = 1e-3
    for k, way in enumerate(np.eye(2) * step):
        ahead, behind = exact.predict(theta + way), exact.predict(theta - way)
        slope = (ahead - behind) / (2.0 * step)
        assert rows[:, k] == pytest.approx(slope, abs=1e-6 * np.abs(slope).max())


def test_damping_that_starts_at_zero_can_be_learned():
    compiled = scene(damping="")
    model = moving(compiled, adjusts("damping"), looks(compiled))
    (block,) = model.shaping.blocks
    assert block.is_difference and block.value(np.array([3.0])) == 3.0
    assert np.abs(model.jacobian(np.zeros(1))).max() > 0.0


def test_a_number_that_a_field_does_not_derive_is_refused(monkeypatch):
    compiled = scene()
    shaping = moving(compiled, adjusts("stiffness", "damping"), looks(compiled)).shaping
    assert refusal(shaping) == ""
    monkeypatch.setattr(Bed, "learnt", ("stiffness", "home"))
    assert refusal(shaping) == "the damping of bed has no exact derivatives"
