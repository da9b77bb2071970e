"""What has exact derivatives keeps them through every event; what has none is refused."""

import numpy as np
import pytest
from msgspec import Struct

from tests.every import every
from tests.learn.trials import adjust, differing, fit, moving, series, sheet
from tissuec.core.structs import replace
from tissuec.learn.derivatives.refusals import refusal_of_script
from tissuec.script.plan import ScheduledAction

TOOLS = """tool tongs { kind is forceps }
tool shears { kind is scissors }"""
#: Of the derivative, by differences over 1 to 4 steps: errors fall with the step to the 8th.
EIGHTH = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
PUSH = "  from 10 ms to 60 ms: push right with (0, 0.05, 0.1) N using smooth profile\n"
SCRIPTS = {
    "nothing": "",
    "cut": "  at 30 ms: cut sheet along plane through (5, 0, 0) mm facing (1, 0, 0)",
    "closing blades": "  from 30 ms to 60 ms: cut sheet along line from (5, -1, 0) mm "
    "to (5, 20, 0) mm facing (1, 0, 0) with shears",
    "trigger": "  when position(right along (0, 0, 1)) < -0.7 mm: {"
    " after 0 s: change spring constant of sheet by 50 %;"
    " after 7.3 ms: push middle with (0.1, 0, 0) N }",
    "held by a trigger": "  when position(right along (0, 0, 1)) < -0.7 mm: {"
    " after 1 ms: fix right; after 11.3 ms: free right }",
    "grip": "  at 20 ms: grasp right with tongs\n"
    "  from 25 ms to 45 ms: move tongs by (1, 2, 3) mm using smooth profile\n"
    "  at 40 ms: grasp middle with tongs\n"
    "  at 60 ms: release middle from tongs\n"
    "  at 70.1 ms: release tongs",
    "release on the way": "  from 20 ms to 60 ms: move right by (1, 2, 3) mm"
    " using constant speed\n  at 40 ms: release right",
    "factors": "  at 30 ms: change spring constant of sheet by 150 %\n"
    "  at 45 ms: change viscosity of sheet by 50 %\n"
    "  at 50 ms: change mass of middle by 70 %",
    "values": "  at 30 ms: change spring constant of sheet to 20 N/m\n"
    "  at 45 ms: change viscosity of sheet to 10 mN*s/m\n"
    "  at 50 ms: change mass of middle to 1 g\n"
    "  at 60 ms: change rest length of sheet to 9 mm",
    "value and factor": "  at 30 ms: change spring constant of sheet to 20 N/m\n"
    "  at 45 ms: change spring constant of sheet by 50 %\n"
    "  at 50 ms: change rest length of sheet by 90 %",
    "surroundings": "  at 30 ms: change gravity to (0, 3, 0) m/s^2\n"
    "  at 45 ms: change damping to 30 mN*s/m",
    "velocity": "  at 30 ms: change velocity of middle to (0.1, 0, 0.3) m/s",
    "velocity it had": "  at 0 s: change velocity of middle to (0, 0, 0) m/s",
    "hold": "  from 30 ms to 50 ms: hold middle",
    "ramp": "  from 10 ms to 40 ms: push middle with (0, 0.05, 0.1) N using ramp",
    "stop pushing": "  at 60 ms: push middle with (0.1, 0, 0) N\n"
    "  at 80 ms: stop pushing middle",
    "push by a sine": "  from 10 ms to 73 ms: push middle with (0, 0.05, 0.1) N"
    " using sine of 30 Hz",
    "push by a table": "  from 5 ms to 90 ms: push middle with (0, 0, 1) N"
    ' using table "factor.csv"',
    "push of held": "  at 0 s: push sheet with (0, 0.05, 0.1) N\n"
    "  at 30 ms: fix right\n  at 60 ms: free right",
    "move": "  from 10 ms to 40 ms: move right by (1, 2, 3) mm using constant speed",
    "moves": "  from 10 ms to 40 ms: move right by (1, 2, 3) mm using smooth profile\n"
    "  from 20 ms to 60 ms: move right by (1, -2, 3) mm using smooth profile",
    "move by a sine": "  from 10 ms to 40 ms: move right by (1, 2, 3) mm using sine of 20 Hz",
    "move by a table": '  from 5 ms to 90 ms: move right along table "path.csv" in mm',
    "stop moving": "  from 10 ms to 40 ms: move right by (1, 2, 3) mm using smooth profile\n"
    "  at 31 ms: stop moving right\n  at 50 ms: free right",
    "repeat": "  from 10 ms to 90 ms every 20 ms: {"
    " after 0 s: push right with (0, 0, -0.1) N; after 10 ms: stop pushing right }",
    "rupture": "  at 0 s: push right with (0, 0.7, 0.3) N",
    "crush": "  at 0 s: push right with (0, -0.2, 0.1) N",
}
BREAKING = {
    "rupture": "; breaking force = 0.2 N",
    "crush": "; breaking force = 9 N; crushing force = 0.05 N",
}
#: Where springs are gone in the end, so that this is seen to be tested.
BROKEN = ("cut", "closing blades", *BREAKING)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("scene")
    (found / "path.csv").write_text("t,x,y,z\n0,0,0,0\n0.02,1,2,1\n0.05,2,-1,3\n0.07,0,1,2\n")
    (found / "factor.csv").write_text("t,factor\n0,0\n0.02,0.1\n0.05,-0.05\n0.07,0.2\n")
    return found


def scene(folder, name):
    tissue = BREAKING.get(name, "")
    return sheet(
        PUSH + SCRIPTS[name],
        tissue=tissue,
        body="rupture is allowed" if tissue else "",
        sets=TOOLS,
        file=folder / "sheet.tis",
    )


def measured_of(compiled):
    times = [0.0, 0.013, 0.03, 0.04, 0.0625, 0.1]
    fits = [
        fit(compiled, "positions", "sheet"),
        fit(compiled, "force", "left", columns=3),
        fit(compiled, "distance", "left", "right"),
        fit(compiled, "length", "sheet"),
    ]
    return [series(one, times) for one in fits]


def adjusts_of(compiled):
    springs, right = np.arange(5, 20), compiled.nodes_of("right")
    every = compiled.nodes_of("sheet")
    return [
        adjust("spring constant", "felt"),
        adjust("viscosity", "felt"),
        adjust("mass", "felt"),
        adjust("rest length", "some", per="set", members=springs),
        adjust("start position", "right", per="node", members=right),
        adjust("start velocity", "sheet", per="set", members=every),
    ]


#: Methods differ in how they step, not in what events are: the implicit one sees each kind.
IMPLICIT = ("cut", "grip", "values", "move by a table")
CASES = [
    *((name, "velocity verlet", 1e-3) for name in SCRIPTS),
    *((name, "rkn4", 2e-3) for name in IMPLICIT),
    *((name, "esdirk43", 2e-2) for name in IMPLICIT),
]


@pytest.mark.parametrize(("name", "method", "step"), CASES)
def test_derivatives_are_those_of_the_frozen_motion(folder, name, method, step):
    compiled = scene(folder, name)
    assert refusal_of_script(compiled.plan, compiled.network) == ""
    model = moving(
        compiled, adjusts_of(compiled), measured_of(compiled), method=method, step=step
    )
    assert model.motion.schedule.legs[-1].is_alive.all() == (name not in BROKEN)
    rng = np.random.default_rng(1)
    nothing = np.zeros(model.shaping.size)
    along, weights = rng.standard_normal(len(nothing)), rng.standard_normal(model.size)
    exact = model.jacobian(nothing) @ along
    assert model.gradient(nothing, weights) @ along == pytest.approx(
        weights @ exact, abs=1e-11 * np.abs(weights * exact).sum()
    )
    h = 5e-4  # small against what bends the motion, large against rounding
    by_differences = sum(
        c * (model.predict(k * h * along) - model.predict(-k * h * along)) / h
        for k, c in enumerate(EIGHTH, 1)
    )
    assert np.abs(by_differences - exact).max() < 1e-7 * np.abs(exact).max()


@pytest.mark.parametrize("name", ["velocity it had", "grip", "values", "closing blades"])
def test_the_frozen_motion_is_that_of_the_engine(folder, name):
    compiled = scene(folder, name)
    arguments = compiled, adjusts_of(compiled), measured_of(compiled)
    theta = np.full(17, 0.02)
    model = moving(*arguments, step=2e-3)
    model.freeze(theta)
    expected = differing(*arguments).predict(theta)
    # The engine keeps the error of places to 1e-11 of 30 mm, steps here to no more than that;
    # forces are that times springs of 40 N/m.
    assert np.abs(model.predict(theta) - expected).max() < 2e-9


SILK = """tissue silk { spring constant = 500 N/m; viscosity = 1 mN*s/m; mass = 0.1 g }
body sling { mesh is thread { centre = (0, 0, 60) mm; normal = (1, 0, 0); radius = 4 mm
  pieces = 16; thickness = 1 mm }; tissue is silk }"""
BALL = """body ball { mesh is sphere { centre = (0, 0, 60) mm; radius = 5 mm; subdivisions = 1 }
  tissue is felt }"""
NOZZLE = """tool nozzle { kind is nozzle; diameter = 2 mm; tip = (10, 15, 60) mm
  direction = (0, 0, -1) }"""
PROBE = "tool probe { kind is probe; radius = 3 mm; centre = (10, 15, 9) mm }"
REFUSED = {
    "settle": ("  at 0 s: settle", {}),
    "turn": ("  from 0 s to 9 ms: turn right by 9 deg around (1, 0, 0) using ramp", {}),
    "turn of a grip": (
        "  at 0 s: grasp right with tongs\n"
        "  from 1 ms to 9 ms: turn tongs by 9 deg around (1, 0, 0) using ramp",
        {"sets": TOOLS},
    ),
    "turn behind a condition": (
        "  when position(right along (0, 0, 1)) < -0.7 mm: {\n"
        "    from 0 s to 9 ms: turn right by 9 deg around (1, 0, 0) using ramp }",
        {},
    ),
    "spin": ("  at 9 ms: change spin of right to (0, 0, 5) Hz", {}),
    "changed relaxing": (
        "  at 9 ms: change relaxing constant of sheet by 150 %",
        {"tissue": "; relaxing constant = 30 N/m; relaxation time = 20 ms"},
    ),
    "relaxation": ("", {"simulate": "integrator is relaxation; step = 10 ms"}),
    "friction": ("", {"sets": PROBE, "contact": "tools only; friction = 0.1"}),
    "volumes": (
        "  at 0 s: preserve volume of ball with 10 kPa\n"
        "  at 9 ms: preserve volume of ball with 20 kPa",
        {"sets": BALL},
    ),
    "jet": ("  at 0 s: irrigate sheet with 5 ml/s through nozzle", {"sets": NOZZLE}),
    "knot": ("  at 0 s: tie sling with square knot of 1 N", {"sets": SILK}),
    "tighten": ("  at 0 s: tighten sling to 20 mm", {"sets": SILK}),
    "loosen": ("  at 0 s: loosen sling to 30 mm", {"sets": SILK}),
}


@every("name", REFUSED)
def test_what_has_no_exact_derivative_is_refused(name):
    script, options = REFUSED[name]
    compiled = sheet(script, **options)
    assert refusal_of_script(compiled.plan, compiled.network)


class OfAnotherPackage(Struct, frozen=True):
    """An action that nothing is known of."""

    span: None = None


def test_actions_that_nothing_is_known_of_have_no_exact_derivatives():
    compiled = sheet("  at 0 s: fix left")
    plan = replace(compiled.plan, events=(ScheduledAction(0.0, OfAnotherPackage()),))
    said = "the verb test_freezing has no exact derivatives"
    assert refusal_of_script(plan, compiled.network) == said


def test_what_ends_a_run_does_not_end_a_prediction(folder):
    whole = scene(folder, "nothing")
    ended = sheet(PUSH + "  at 30 ms: end the run", sets=TOOLS, file=folder / "sheet.tis")
    models = [
        moving(one, adjusts_of(one)[:1], measured_of(one), method="velocity verlet", step=1e-3)
        for one in (whole, ended)
    ]
    nothing = np.zeros(1)
    assert np.array_equal(*(model.predict(nothing) for model in models))
