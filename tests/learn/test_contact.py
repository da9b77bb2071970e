"""Contact without friction has exact derivatives, in motions and in equilibria."""

import numpy as np
import pytest

from tests.learn.test_fields import check_both_directions
from tests.learn.test_motion import motion_of
from tests.learn.test_resting import assert_derived, csv, model  # noqa: F401  # a fixture
from tests.learn.trials import adjust, differing, fit, moving, series, sheet
from tests.validate.scenes import compiled_scene
from tissuec.core.structs import replace
from tissuec.learn.derivatives.finite_differences import FiniteDifferenceModel
from tissuec.learn.derivatives.refusals import refusal
from tissuec.learn.fit.session import prepare
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

FLESH = """tissue flesh { spring constant = 20 N/m; density = 1000 kg/m^3
  retardation time = 1 ms }"""
#: A pad that falls on a plate that is aslant, and springs back.
PAD = f"""language 1
{FLESH}
body pad {{
  mesh is lattice {{ kind is sodium chloride; cell = 5 mm; reach is second neighbours
  box from (0, 0, 1) mm to (10, 10, 6) mm }}; tissue is flesh }}
tool plate {{ kind is plane; point = (0, 0, 0) mm; normal = (0.1, 0.05, 1) }}
environment {{ gravity = (0, 0, -9.81) m/s^2; contact is tools only; contact damping = 1 s/m }}
script {{ at 0 s: change velocity of pad to (0.1, 0, -0.5) m/s
  from 0 s to 20 ms: move plate by (0, 0, 2) mm using smooth profile }}
simulate {{ duration = 20 ms; tolerance = 1e-8 }}
"""
#: A ball that is thrown on a sheet and rolls along it, and a hook that draws it on.
BALL = f"""language 1
{FLESH}
body ball {{
  mesh is sphere {{ centre = (1, 2, 6) mm; radius = 4 mm; subdivisions = 1 }}
  tissue is flesh; thickness = 2 mm }}
body floor {{
  mesh is sheet {{ corner = (-10, -10, 0) mm; first edge = (20, 0, 0) mm
  second edge = (0, 20, 0) mm; columns = 5; rows = 5; diagonals is both }}
  tissue is flesh; thickness = 2 mm }}
set rim = nodes of floor where x < -9 mm or x > 9 mm
tool rod {{ kind is probe; radius = 1 mm; axis from (-6, -8, 7) mm to (-6, 8, 6) mm }}
environment {{ gravity = (0, 0, -9.81) m/s^2; contact is bodies too; contact thickness = 1 mm }}
script {{ at 0 s: fix rim; at 0 s: change velocity of ball to (0.2, 0, -0.6) m/s
  from 0 s to 20 ms: move rod by (5, 0, 0) mm using smooth profile }}
simulate {{ duration = 20 ms; tolerance = 1e-8 }}
"""
#: With differences that are small enough, for the law has other formulas at some depths.
SCENES = {"pad": (PAD, 1e-4), "ball": (BALL, 1e-5)}
STEPS = {"velocity verlet": 2e-5, "dop853": 2e-4}
TIMES = np.array([4.3e-3, 11e-3, 20e-3])


@pytest.mark.parametrize("name", STEPS)
@pytest.mark.parametrize("scene", SCENES)
def test_derivatives_of_both_directions_are_those_of_the_steps(scene, name):
    text, size = SCENES[scene]
    compiled = compiled_scene(text)
    check_both_directions(compiled, name, STEPS[name], TIMES, size=size)


def test_the_wider_a_motion_the_wider_is_what_counts_as_near():
    compiled = compiled_scene(PAD)
    short, vector = motion_of(compiled, "dop853", 2e-4, TIMES, TIMES[-1])
    expected = short.forward(vector)
    # A contact that looks a tenth as far has to look again.
    contact = compiled.network.contact
    near = replace(contact, stride=0.02 * contact.stride)
    network = compiled.network.with_blocks(near.block)
    wide, vector = motion_of(
        replace(compiled, network=network), "dop853", 2e-4, TIMES, TIMES[-1]
    )
    assert np.array_equal(wide.forward(vector).x, expected.x)


#: A block whose top is moved down onto a rod, along which it bends.
PRESSED = f"""language 1
{FLESH}
body block {{ mesh is lattice {{ kind is sodium chloride; cell = 5 mm
  reach is second neighbours
  box from (0, 0, 0) mm to (15, 10, 5) mm }}; tissue is flesh }}
set top = nodes of block where z > 4 mm
set middle = nodes of block where x between 4 mm and 11 mm and z < 1 mm
tool rod {{ kind is probe; radius = 3 mm; axis from (5, -9, -4) mm to (7, 20, -4) mm }}
environment {{ gravity = (0, 0, -9.81) m/s^2; contact is tools only; {{more}} }}
script {{ from 0 s to 1 s: move top by (0, 0, -2) mm using smooth profile }}
simulate {{ duration = 1 s }}
learn flesh {{ data = "data.csv"; displacement of top using column "u" in mm
  fit = force({{of}}) using columns "f g h" in N
  fit = position(middle) along (0, 0, 1) using column "f" in mm
  adjust spring constant; adjust density }}
"""


def test_equilibria_have_the_derivatives_of_their_predictions(model):  # noqa: F811
    text = PRESSED.replace("{more}", "").replace("{of}", "top")
    found, _ = model(text, csv([0.5, 1.7]))
    assert_derived(found, np.array([0.02, -0.05]))


FELT = [adjust("spring constant", "felt"), adjust("mass", "felt")]
PROBE = {
    "sets": "tool probe { kind is probe; radius = 6 mm; centre = (10, 20, -7) mm }",
    "contact": "tools only",
}


def looked_at(compiled):
    times = np.array([20e-3, 50e-3, 80e-3])
    return [series(fit(compiled, name, "probe", columns=3), times) for name in ("force",)]


def test_the_force_of_a_tool_has_the_derivatives_of_whole_runs():
    script = "  from 0 s to 60 ms: move probe by (0, 0, 6) mm using smooth profile"
    compiled = sheet(script, **PROBE)
    exact, runs = (make(compiled, FELT, looked_at(compiled)) for make in (moving, differing))
    theta = np.array([0.1, -0.1])
    # The stiffness of contact is that of springs, which are learned.
    values, rows = exact.predict(theta), exact.jacobian(theta)
    assert np.abs(values).max() > 1e-3
    assert values == pytest.approx(runs.predict(theta), abs=1e-4 * np.abs(values).max())
    expected = runs.jacobian(theta)
    assert rows == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())


REFUSED = {
    "has friction": ({"contact": "tools only; friction = 0.1"}, FELT),
    "start positions": ({}, [adjust("start position", "right", per="set")]),
    "the contact stiffness follows": ({}, [adjust("spring constant", "sheet", per="set")]),
}


@pytest.mark.parametrize("said", REFUSED)
def test_what_has_no_exact_derivatives_is_refused(said):
    options, adjusts = REFUSED[said]
    compiled = sheet(**{**PROBE, **options})
    named = {"right": compiled.nodes_of, "sheet": compiled.springs_of}
    adjusts = [
        replace(one, members=named[one.of](one.of)) if one.of in named else one
        for one in adjusts
    ]
    shaping = differing(compiled, adjusts, looked_at(compiled)).shaping
    assert said in refusal(shaping)


def test_bodies_that_touch_one_another_have_no_exact_equilibria(tmp_path):
    more = "contact thickness = 1 mm"
    text = PRESSED.replace("tools only", "bodies too").replace("{more}", more)
    (tmp_path / "data.csv").write_text(csv([0.5, 1.7]))
    path = tmp_path / "scene.tis"
    path.write_text(text.replace("{of}", "top"))
    request = Request.file(path)
    compiled, _ = compile_request(request)
    (trial,) = prepare(compiled, compiled.fit_problems[0], request).learning
    assert isinstance(trial.model, FiniteDifferenceModel)
    assert "bodies touch one another" in trial.model.notes[0]
