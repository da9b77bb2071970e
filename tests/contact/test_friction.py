"""Friction: Coulomb's law where things slide, a bristle where they stick, rolling between."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from tests.contact.scenes import ball, bodies, gap_of_balance, play
from tests.validate.scenes import validated
from tissuec.forces.contact.friction_kernel import LARGEST, SHARPNESS, bristle_ahead

GRAVITY, FRICTION, STIFFNESS, LAYER, MASS = 9.81, 0.5, 1e3, 0.1e-3, 1e-3
LIMIT = np.degrees(np.arctan(FRICTION))
FLOOR = "tool floor { kind is plane; point = (0, 0, 0) mm; normal = (0, 0, 1) }"


def slope(degrees, body, *, drag=0.0, duration=1.0, more=""):
    """Return the text of a body on a floor, in gravity that is tilted towards x."""
    a = np.radians(degrees)
    return f"""{body}
{FLOOR}
environment {{
  gravity = ({GRAVITY * np.sin(a):.15g}, 0, {-GRAVITY * np.cos(a):.15g}) m/s^2
  contact is tools only; friction = {FRICTION}; {more}
  contact stiffness = {STIFFNESS} N/m; contact layer = {1e3 * LAYER} mm
  damping = {drag} N*s/m
}}
simulate {{ duration = {duration} s; tolerance = 1e-6 }}
output {{ trajectory every {duration / 200} s; force of floor every 1 ms; energy every 10 ms }}
"""


def resting(degrees, mass=MASS):
    """Return the text of a mass that lies as deep in the floor as carries its weight."""
    pressure = mass * GRAVITY * np.cos(np.radians(degrees))
    assert pressure < 0.5 * STIFFNESS * LAYER
    deep = np.sqrt(2.0 * LAYER * pressure / STIFFNESS)
    return ball(height=f"{-1e3 * deep:.15g} mm", mass=f"{1e3 * mass} g")


@pytest.mark.parametrize(
    ("degrees", "mass"), [(5.0, MASS), (20.0, MASS), (LIMIT - 0.1, MASS), (20.0, 1e-3 * MASS)]
)
def test_a_mass_below_the_friction_angle_stays_where_it_is(degrees, mass):
    text = slope(degrees, resting(degrees, mass), drag=200.0 * mass, duration=0.5)
    played = play(text)
    x = played.position[:, 0, 0]
    pressure = mass * GRAVITY * np.cos(np.radians(degrees))
    reach = pressure / STIFFNESS + 0.5 * LAYER  # of a bristle: κ is N / reach
    elastic = np.tan(np.radians(degrees)) * reach
    # It comes to rest within some bristles' lengths, and then not even creeps.
    assert x[-1] < 10.0 * elastic
    assert abs(x[-1] - x[len(x) // 2]) < 1e-3 * elastic
    _, force = played.log("force of floor")
    a = np.radians(degrees)
    weight = mass * GRAVITY * np.array([np.sin(a), 0.0, -np.cos(a)])
    # What holds the floor pulls it against the weight that lies on it.
    assert force[-1] == pytest.approx(-weight, abs=1e-5 * mass * GRAVITY)


@pytest.mark.parametrize("degrees", [LIMIT + 0.1, 30.0, 60.0])
def test_a_mass_above_the_friction_angle_slides_with_the_rest_of_its_weight(degrees):
    played = play(slope(degrees, resting(degrees), duration=0.2))
    a = np.radians(degrees)
    expected = GRAVITY * (np.sin(a) - FRICTION * np.cos(a))
    late = played.time > 0.1
    found = np.polyfit(played.time[late], played.velocity[late, 0, 0], 1)[0]
    # From the bristles' bending on, the law is exact.
    assert found == pytest.approx(expected, rel=1e-4)
    # Positions are known to 1e-6, and energies are wrong by twice that.
    assert gap_of_balance(played) < 2e-6


BLOCK = """language 1
tissue wood { spring constant = 2 kN/m; viscosity = 0.2 N*s/m; mass = 1 g }
body block {
  mesh is lattice { kind is sodium chloride; cell = 10 mm; reach is second neighbours
    box from (0, 0, 0) mm to (20, 20, 10) mm }
  tissue is wood
}"""


def test_a_block_slides_above_the_friction_angle():
    a = np.radians(LIMIT + 3.0)
    text = slope(LIMIT + 3.0, BLOCK, duration=0.5, more="contact damping = 5 s/m;")
    played = play(text)
    velocity = played.velocity[:, bodies(played), 0].mean(axis=1)
    late = played.time > 0.2
    found = np.polyfit(played.time[late], velocity[late], 1)[0]
    assert found == pytest.approx(GRAVITY * (np.sin(a) - FRICTION * np.cos(a)), rel=0.01)


def test_a_block_sticks_below_the_friction_angle():
    text = slope(LIMIT - 3.0, BLOCK, duration=0.5, drag=0.1, more="contact damping = 5 s/m;")
    played = play(text)
    place = played.position[:, bodies(played), 0]
    assert np.abs(place[-1] - place[len(place) // 2]).max() < 1e-8


# --- the bristle ----------------------------------------------------------------------------

DEPTH = 2.0 * LAYER
PRESSURE = STIFFNESS * (DEPTH - 0.5 * LAYER)
LENGTH = FRICTION * (PRESSURE / STIFFNESS + 0.5 * LAYER)  # of a bristle that slips
BENT = FRICTION * PRESSURE / LENGTH  # its stiffness, κ


def dragged(path, duration):
    """Return the text of a mass that is drawn along the floor at a constant depth."""
    return f"""{ball(height=f"{-1e3 * DEPTH} mm")}
set tip = nodes of ball where id == 1
{FLOOR}
environment {{
  gravity = (0, 0, 0) m/s^2; contact is tools only; friction = {FRICTION}
  contact stiffness = {STIFFNESS} N/m; contact layer = {1e3 * LAYER} mm
}}
script {{ {path} }}
simulate {{ duration = {duration} s; tolerance = 1e-8 }}
output {{ trajectory every 5 ms; force of tip every 5 ms; energy every 5 ms }}
"""


def bent(slid):
    """Return the force of a straight bristle after a way in one direction [N], shape (way,).

    From dz/dx = 1 - (z/l)^8 the way is l ∫ ds/(1 - s^8) up to z/l.
    """
    part = 1.0 - np.logspace(0.0, -9.0, 500)
    each = [quad(lambda s: 1.0 / (1.0 - s**8), a, b)[0] for a, b in pairwise(part)]
    ways = np.cumsum([0.0, *each])
    return FRICTION * PRESSURE * np.interp(np.asarray(slid) / LENGTH, ways, part)


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.6, -0.8)])
def test_force_grows_elastically_and_saturates_as_the_law_of_the_bristle_says(direction):
    way = 4.0 * LENGTH
    x, y = 1e3 * way * np.array(direction)
    move = f"from 0 s to 1 s: move tip by ({x:.15g}, {y:.15g}, 0) mm using constant speed"
    played = play(dragged(move, 1.0))
    time, force = played.log("force of tip")
    along = force[:, :2] @ direction
    # Steps of 1e-8, and 500 values of the integral between which it is interpolated.
    assert along == pytest.approx(bent(way * time), abs=2e-4 * FRICTION * PRESSURE)
    early = (time > 0.0) & (way * time < 0.3 * LENGTH)
    assert along[early] == pytest.approx(BENT * way * time[early], rel=1e-4)
    assert along.max() <= FRICTION * PRESSURE * (1.0 + 1e-9)
    across = force[:, :2] @ [-direction[1], direction[0]]
    assert np.abs(across).max() < 1e-9 * along.max()
    assert force[:, 2] == pytest.approx(-PRESSURE)  # who drags holds it down
    _, energies = played.energies()
    assert energies["work"] == pytest.approx(
        energies["dissipated"], abs=1e-9 * along.max() * way
    )


def test_force_turns_over_elastically_and_saturates_the_other_way():
    there, back = 4.0 * LENGTH, -6.0 * LENGTH
    moves = f"""
  from 0 s to 1 s: move tip by ({1e3 * there:.15g}, 0, 0) mm using constant speed
  from 1 s to 2 s: move tip by ({1e3 * back:.15g}, 0, 0) mm using constant speed"""
    played = play(dragged(moves, 2.0))
    time, force = played.log("force of tip")
    returned = -back * (time - 1.0)
    along, full = force[:, 0], FRICTION * PRESSURE
    straight = (returned > 0.0) & (returned < LENGTH)
    # Back through the middle and a little beyond it without any slip.
    straight = (returned > 0.0) & (returned < 1.3 * LENGTH)
    expected = full - BENT * returned[straight]
    assert along[straight] == pytest.approx(expected, abs=2e-3 * full)
    assert along[-1] == pytest.approx(-full, rel=2e-3)
    assert np.all(np.diff(played.energies()[1]["dissipated"])[time[1:] > 1.5] > 0.0)


def test_what_is_pulled_steadily_below_the_limit_does_not_creep():
    text = dragged("at 0 s: push tip with (PULL, 0, 0) N", 1.0)
    text = text.replace("gravity = (0, 0, 0)", f"gravity = (0, 0, {-PRESSURE / MASS:.15g})")
    text = text.replace("contact is", "damping = 0.5 N*s/m; contact is")
    for part in (0.3, 0.8):
        pull = part * FRICTION * PRESSURE
        played = play(text.replace("PULL", f"{pull:.15g}"))
        x = played.position[:, 0, 0]
        assert x[-1] > 0.9 * pull / BENT
        assert abs(x[-1] - x[len(x) // 4]) < 1e-4 * pull / BENT


def test_what_leaves_the_floor_forgets_how_it_was_bent():
    moves = f"""
  from 0 s to 1 s: move tip by ({2e3 * LENGTH:.15g}, 0, 0) mm using constant speed
  from 1 s to 1.1 s: move tip by (0, 0, 1) mm using smooth profile
  from 1.3 s to 1.4 s: move tip by (0, 0, -1) mm using smooth profile"""
    played = play(dragged(moves, 1.5))
    time, force = played.log("force of tip")
    assert force[time < 1.0][-1, 0] > 0.9 * FRICTION * PRESSURE
    assert np.all(force[(time > 1.1) & (time < 1.3)] == 0.0)
    assert force[-1, 2] == pytest.approx(-PRESSURE)
    assert abs(force[-1, 0]) < 1e-6 * PRESSURE


# --- rolling --------------------------------------------------------------------------------


def rolling(subdivisions, degrees, friction="0.8"):
    a = np.radians(degrees)
    return f"""language 1
tissue ivory {{ spring constant = 5 kN/m; viscosity = 0 N*s/m; mass = 1 g }}
body ball {{
  mesh is sphere {{
    centre = (0, 0, 10) mm; radius = 10 mm; subdivisions = {subdivisions}; interior is spokes
  }}
  tissue is ivory; mass = 10 g
}}
{FLOOR}
environment {{
  gravity = ({GRAVITY * np.sin(a):.15g}, 0, {-GRAVITY * np.cos(a):.15g}) m/s^2
  contact is tools only; friction = {friction}
  contact stiffness = 3 kN/m; contact layer = 0.05 mm; contact damping = 1 s/m
}}
simulate {{ duration = 0.2 s; tolerance = 1e-5; integrator is dop853 }}
output {{ trajectory every 2 ms; energy every 2 ms }}
"""


def rolled(subdivisions, degrees, friction="0.8"):
    """Return acceleration [m/s²], its closed form, and the turned angle [rad] of a ball."""
    played = play(rolling(subdivisions, degrees, friction))
    nodes = bodies(played)
    place = played.position[:, nodes]
    middle = place.mean(axis=1)
    arm = place[0] - middle[0]
    moment = (arm[:, 0] ** 2 + arm[:, 2] ** 2).mean()
    expected = GRAVITY * np.sin(np.radians(degrees)) / (1.0 + moment / 10e-3**2)
    found = 2.0 * np.polyfit(played.time, middle[:, 0], 2)[0]
    last = place[-1] - middle[-1]
    turned = arm[:, 2] @ last[:, 0] - arm[:, 0] @ last[:, 2]
    kept = arm[:, 0] @ last[:, 0] + arm[:, 2] @ last[:, 2]
    return found, expected, np.arctan2(turned, kept), middle[-1, 0] - middle[0, 0]


@pytest.mark.parametrize(
    ("subdivisions", "degrees", "tolerance"),
    [  # facets of 18 and 9 degrees
        (2, 30.0, 0.02),
        pytest.param(2, 20.0, 0.02, marks=pytest.mark.slow),
        pytest.param(3, 20.0, 0.01, marks=pytest.mark.slow),
        pytest.param(3, 30.0, 0.01, marks=pytest.mark.slow),
    ],
)
def test_a_ball_rolls_down_as_slowly_as_its_moment_of_inertia_asks(
    subdivisions, degrees, tolerance
):
    found, expected, turned, way = rolled(subdivisions, degrees)
    assert found == pytest.approx(expected, rel=tolerance)
    angle = way / 10e-3
    assert np.exp(1j * turned) == pytest.approx(np.exp(1j * angle), abs=0.1 * angle)


def test_a_ball_without_friction_slides_and_does_not_turn():
    found, _, turned, _ = rolled(2, 20.0, "0")
    assert found == pytest.approx(GRAVITY * np.sin(np.radians(20.0)), rel=1e-4)
    assert abs(turned) < 1e-3


def test_friction_where_nothing_can_touch_changes_nothing():
    text = """language 1
tissue wire { spring constant = 40 N/m; viscosity = 0 N*s/m; mass = 1 g }
body rod { mesh is explicit; tissue is wire; spin = (0, 0, 9) rad/s }
table nodes of rod in mm with columns "x y" { 0 0; 10 0; 0 10 }
table springs of rod with columns "a b" { 1 2; 2 3; 3 1 }
environment { gravity = (0, 0, -9.81) m/s^2; contact is everywhere; friction = 0.3 }
simulate { duration = 50 ms }
output { trajectory every 10 ms }
"""
    alone = text.replace("contact is everywhere; friction = 0.3", "contact is off")
    assert np.array_equal(play(text).position, play(alone).position)
    assert validated(text).verdict == "kept"


# --- implicit stages ------------------------------------------------------------------------


def test_an_implicit_stage_solves_for_its_bristle():
    """z = b + lag z' with the law of the bristle, at lags up to thousands of its lengths."""
    random = np.random.default_rng(1)
    for _ in range(300):
        slips, lag = 10.0 ** random.uniform(-6, -3), 10.0 ** random.uniform(-7, -1)
        u = random.normal(size=3) * slips / lag * 10.0 ** random.uniform(-3, 3)
        b = random.normal(size=3) * slips * random.choice([0.0, 0.3, 1.0])
        unbend = random.uniform(-0.9, 5.0) / lag * random.choice([0.0, 1.0])
        z = np.array(bristle_ahead(lag, *b, *u, unbend, slips))
        d, length = u - unbend * z, np.linalg.norm(z)
        slip = max(d @ z, 0.0) / length**2 * min(length / slips, LARGEST) ** SHARPNESS
        size = np.linalg.norm(b + lag * u)
        assert z == pytest.approx(b + lag * (d - slip * z), abs=1e-9 * size)


LANDING = """{ball}
{floor}
environment {{
  gravity = (0, 0, -9.81) m/s^2; contact is tools only; friction = 0.3
  contact stiffness = 1 kN/m; contact layer = 1 mm
}}
simulate {{ integrator is {method}; duration = 60 ms; tolerance = {tolerance} }}
output {{ trajectory every 1 ms }}
"""


@cache
def landing(method, tolerance):
    """Return where a mass is that lands [m], shape (frame, 3)."""
    flying = ball(height="1 mm", velocity="(1, 0, 0) m/s", mass="10 g")
    text = LANDING.format(ball=flying, floor=FLOOR, method=method, tolerance=tolerance)
    return play(text).position[:, 0]


@pytest.mark.parametrize("method", ["esdirk43", "trbdf2", "rkc2", "velocity verlet", "rkn4"])
def test_a_mass_that_lands_gets_friction_from_every_method(method):
    exact, found = landing("dop853", 1e-8), landing(method, 1e-4)
    assert exact[-1, 0] < 0.056  # of the 60 mm that it would slide without friction
    assert np.abs(found - exact).max() < 1e-4 * 0.06


RUBBED = """language 1
tissue cord { spring constant = 280 N/m; viscosity = 0.012 N*s/m; mass = 0.17 g }
body block { mesh is lattice { kind is sodium chloride; reach is second neighbours; cell = 5 mm
  box from (0, 0, 0) mm to (15, 15, 5) mm }; tissue is cord }
set base = nodes of block where z < 0.1 mm
tool probe { kind is probe; radius = 7.42 mm; centre = (8.95, 4.78, 13.2) mm }
environment { gravity = (0, 0, -9.81) m/s^2; contact is tools only; friction = 0.3 }
script {
  at 0 s: fix base
  from 0 s to 63 ms: move probe by (0, 0, -1.97) mm using smooth profile
  from 63 ms to 126 ms: move probe by (3.97, 2.23, 0) mm using smooth profile
  from 126 ms to 189 ms: move probe by (0, 0, 4) mm using smooth profile
}
simulate { duration = 190 ms; tolerance = TOLERANCE }
output { trajectory every 10 ms }
"""


def test_where_contact_begins_bristles_do_not_stop_a_run_at_any_tolerance():
    found = {}
    for tolerance in ("1e-7", "1e-8", "1e-9"):
        played = play(RUBBED.replace("TOLERANCE", tolerance))
        assert played.outcome.kind == "done", played.outcome.message
        found[tolerance] = played.position
    moved = np.abs(found["1e-9"] - found["1e-9"][0]).max()
    for tolerance in ("1e-7", "1e-8"):
        error = np.abs(found[tolerance] - found["1e-9"]).max() / moved
        # Both runs may be wrong by their own tolerance.
        assert error < float(tolerance) + 1e-9
