"""What touches moves by the laws of mechanics: bounces, impulses, energy, no way through."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp, trapezoid

from tests.contact.scenes import ball, bodies, gap_of_balance, play
from tissuec.engine import engine

GRAVITY, HEIGHT = 9.81, 10e-3
FLOOR = "tool floor { kind is plane; point = (0, 0, 0) mm; normal = (0, 0, 1) }"


def dropped(
    *, stiffness=10e3, layer=0.02e-3, damping=0.0, duration=0.3, frames="0.1 ms", forces="1 ms",
    tolerance="1e-6",
):  # fmt: skip
    """Return the text of a mass of 1 g that falls 10 mm onto a floor."""
    return f"""{ball(height="10 mm")}
{FLOOR}
environment {{
  gravity = (0, 0, -{GRAVITY}) m/s^2; contact is tools only
  contact stiffness = {stiffness} N/m; contact layer = {1e3 * layer} mm
  contact damping = {damping} s/m
}}
simulate {{ duration = {duration} s; tolerance = {tolerance} }}
output {{ trajectory every {frames}; force of floor every {forces}; energy every 1 ms }}
"""


def touching_time(stiffness, layer, mass=1e-3):
    """Return how long a mass that fell 10 mm touches the floor [s].

    The law is k δ²/2w, then k (δ - w/2): with v² = 2 g h + 2 g δ - 2 E(δ)/m the time in the
    layer is 2 ∫ dδ/v, and below it half a swing of frequency √(k/m), less what lies above.
    """
    square = 2.0 * GRAVITY * HEIGHT

    def slowness(depth):
        energy = stiffness * depth**3 / (6.0 * layer)
        return 1.0 / np.sqrt(square + 2.0 * GRAVITY * depth - 2.0 * energy / mass)

    energy = stiffness * layer**2 / 6.0
    entering = np.sqrt(square + 2.0 * GRAVITY * layer - 2.0 * energy / mass)
    omega = np.sqrt(stiffness / mass)
    middle = 0.5 * layer + GRAVITY / omega**2
    swing = np.pi + 2.0 * np.arctan2(omega * (middle - layer), entering)
    return 2.0 * quad(slowness, 0.0, layer)[0] + swing / omega


@pytest.mark.parametrize("layer", [0.02e-3, 0.1e-3])
def test_a_mass_returns_to_its_height_and_touches_as_long_as_the_law_says(layer):
    played = play(dropped(layer=layer, frames="1 ms"))
    assert gap_of_balance(played) < 1e-6  # the tolerance
    height, speed = played.position[:, 0, 2], played.velocity[:, 0, 2]
    top = np.flatnonzero((np.diff(height)[:-1] > 0.0) & (np.diff(height)[1:] <= 0.0)) + 1
    assert len(top) == 3
    # From a sample beside a top the free flight tells the top; the tolerance is 10 nm.
    assert height[top] + speed[top] ** 2 / (2.0 * GRAVITY) == pytest.approx(HEIGHT, abs=10e-9)
    period = 2.0 * np.sqrt(2.0 * HEIGHT / GRAVITY) + touching_time(10e3, layer)
    when = played.time[top] + speed[top] / GRAVITY
    # 10 nm take 0.02 µs at the floor; six passages and three flights add up.
    assert when == pytest.approx(period * np.arange(1, 4), abs=0.2e-6)
    text = dropped(layer=layer, forces="20 us", duration=0.06)
    _, force = play(text).log("force of floor")
    touching = 20e-6 * np.count_nonzero(force[:, 2])
    assert touching == pytest.approx(touching_time(10e3, layer), abs=40e-6)


def bounced(times, *, stiffness=10e3, layer=0.02e-3, mass=1e-3):
    """Return heights [m] of the mass by SciPy, from bend to bend of the law."""
    laws = (  # above the floor, in the layer, and below it
        lambda z: 0.0,
        lambda z: stiffness * z * z / (2.0 * layer),
        lambda z: stiffness * (-z - 0.5 * layer),
    )
    heights, start, state, where = np.empty_like(times), 0.0, [HEIGHT, 0.0], 0
    while start < times[-1]:
        ends, ways = [], []
        for way, height in ((-1, -layer * where), (1, -layer * (where - 1))):
            if 0 <= where - way <= 2:

                def end(t, y, height=height):
                    return y[0] - height

                end.terminal, end.direction = True, way
                ends.append(end)
                ways.append(way)
        found = solve_ivp(
            lambda t, y, push=laws[where]: (y[1], push(y[0]) / mass - GRAVITY),
            (start, times[-1]), state, method="DOP853", rtol=1e-13, atol=1e-18,
            dense_output=True, events=ends,
        )  # fmt: skip
        inside = (times >= start) & (times <= found.t[-1])
        if inside.any():
            heights[inside] = found.sol(times[inside])[0]
        start, state = found.t[-1], found.y[:, -1]
        where -= sum(w for w, hit in zip(ways, found.t_events, strict=True) if len(hit))
    return heights


@pytest.mark.parametrize("tolerance", ["1e-3", "1e-6", "1e-8", "3e-9", "1e-9", "3e-10"])
def test_a_bouncing_mass_keeps_every_tolerance(tolerance):
    played = play(dropped(tolerance=tolerance, frames="5 ms", forces="5 ms"))
    height = played.position[:, 0, 2]
    off = np.abs(height - bounced(played.time))
    reach = np.maximum.accumulate(np.abs(height - HEIGHT))
    assert (off[1:] < float(tolerance) * reach[1:]).all()


def test_impulse_of_the_floor_is_the_change_of_momentum():
    played = play(dropped(duration=0.06, frames="1 ms", forces="20 us"))
    moment, force = played.log("force of floor")
    impulse = trapezoid(-force, moment, axis=0)
    change = 1e-3 * played.velocity[-1, 0] + [0.0, 0.0, 1e-3 * GRAVITY * 0.06]
    assert change == pytest.approx(-impulse, abs=1e-4 * abs(change[2]))


@pytest.mark.parametrize("damping", [0.3, 1.0, 5.0])
def test_contact_damping_takes_the_same_part_of_every_speed_as_theory_says(damping):
    """Hunt and Crossley's contact: v' is known in closed form, whatever the elastic law.

    From m v dv = -f(δ) (1 + b v) dδ the approach and the return have the same area of
    (v - ln(1 + b v)/b)/b; gravity is left out, being 1 % of the force of this stiff floor.
    """
    played = play(dropped(damping=damping, stiffness=1e5, duration=0.12, frames="1 ms"))
    fast = np.sqrt(2.0 * GRAVITY * HEIGHT)
    height = played.position[:, 0, 2]
    rising = np.flatnonzero(played.velocity[:, 0, 2] > 0.0)[0]
    back = np.sqrt(2.0 * GRAVITY * height[rising:].max())

    def area(v):
        return v - np.log1p(damping * v) / damping

    speeds = np.linspace(1e-6, min(fast, (1.0 - 1e-9) / damping), 200_001)
    # On the way out the same with -v, up to where the area is that of the approach.
    gone = -np.log1p(-damping * speeds) / damping - speeds
    expected = speeds[np.searchsorted(gone, area(fast))]
    assert back == pytest.approx(expected, rel=0.01)
    assert gap_of_balance(played) < 1e-5


def test_an_elastic_ball_bounces_as_a_rigid_one_with_its_nodes_would():
    radius, stiffness, layer, start = 10e-3, 300.0, 0.1e-3, 5e-3
    text = f"""language 1
tissue rubber {{ spring constant = 20 kN/m; viscosity = 0 N*s/m; mass = 1 g }}
body ball {{
  mesh is sphere {{
    centre = (0, 0, 15) mm; radius = 10 mm; subdivisions = 1; interior is spokes
  }}
  tissue is rubber; mass = 10 g
}}
{FLOOR}
environment {{
  gravity = (0, 0, -{GRAVITY}) m/s^2; contact is tools only
  contact stiffness = {stiffness} N/m; contact layer = 0.1 mm
}}
simulate {{ duration = 0.12 s; tolerance = 1e-5 }}
output {{ trajectory every 0.2 ms; energy every 1 ms }}
"""
    played = play(text)
    nodes = bodies(played)
    assert gap_of_balance(played) < 1e-4
    place = played.position[:, nodes]
    height = place[:, :, 2].mean(axis=1)
    below = place[0, :, 2] - height[0]

    def fall(_, y):
        depth = np.maximum(-(y[0] + below), 0.0)
        bent = np.where(depth < layer, depth**2 / (2.0 * layer), depth - 0.5 * layer)
        return [y[1], stiffness * bent.sum() / 10e-3 - GRAVITY]

    exact = solve_ivp(
        fall, (0.0, 0.12), [radius + start, 0.0], "DOP853", played.time, rtol=1e-10, atol=1e-12
    )
    assert exact.y[0].min() < radius - 1e-3
    again = played.time > 0.06
    assert height[again].max() == pytest.approx(exact.y[0][again].max(), rel=0.01)
    # The bounce takes 65 ms.
    back = (played.time[again][each[again].argmax()] for each in (height, exact.y[0]))
    assert next(back) == pytest.approx(next(back), rel=0.01)


def struck(
    *,
    friction="0",
    damping="0 s/m",
    tool="radius = 5 mm; centre = (0, 0, 18) mm",
    forces="50 us",
):
    """Return the text of a free ball that a probe runs into, a little beside its middle."""
    return f"""language 1
tissue rubber {{ spring constant = 100 N/m; viscosity = 20 mN*s/m; mass = 1 g }}
body ball {{
  mesh is sphere {{
    centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 1; interior is spokes
  }}
  tissue is rubber; mass = 10 g
}}
tool probe {{ kind is probe; {tool} }}
environment {{
  gravity = (0, 0, 0) m/s^2; contact is tools only; friction = {friction}
  contact stiffness = 500 N/m; contact layer = 0.5 mm; contact damping = {damping}
}}
script {{ from 0 s to 40 ms: move probe by (2, 1, -12) mm using smooth profile }}
simulate {{ duration = 60 ms; tolerance = 1e-6 }}
output {{ trajectory every 1 ms; force of probe every {forces}; energy every 1 ms }}
"""


@pytest.mark.parametrize("friction", ["0", "0.5"])
def test_momentum_that_a_free_body_gets_is_what_the_probe_gives(friction):
    played = play(struck(friction=friction, damping="0.5 s/m"))
    mass = played.compiled.network.mass[bodies(played), None]
    momentum = (mass * played.velocity[-1, bodies(played)]).sum(axis=0)
    time, force = played.log("force of probe")
    given = -trapezoid(-force, time, axis=0)
    assert np.linalg.norm(momentum) > 1e-3
    # The trapezoidal rule with 1200 points of a smooth force.
    assert momentum == pytest.approx(given, abs=1e-4 * np.linalg.norm(momentum))


def test_a_body_is_turned_by_the_moment_of_the_probe_about_its_own_place():
    played = play(struck())
    nodes, probe = bodies(played), played.compiled.network.tools[0].nodes.start
    mass = played.compiled.network.mass[nodes, None]
    arm = np.cross(played.position[:, nodes], mass * played.velocity[:, nodes]).sum(axis=1)
    time, force = played.log("force of probe")
    every = slice(None, None, 20)
    assert time[every] == pytest.approx(played.time)
    moment = np.cross(played.position[:, probe], -force[every])
    given = np.concatenate([[0.0 * arm[0]], np.cumsum(0.5 * (moment[1:] + moment[:-1]), 0)])
    given *= -1e-3
    assert np.abs(arm[-1]).max() > 1e-6
    # The trapezoidal rule with 60 points.
    assert np.abs(arm - given).max() < 1e-2 * np.abs(arm).max()


@pytest.mark.parametrize("friction", ["0", "0.5"])
@pytest.mark.parametrize(
    "tool",
    [
        "radius = 5 mm; centre = (0, 0, 18) mm",
        "radius = 4 mm; axis from (-20, 1, 15) mm to (14, 0, 18) mm",
    ],
)
def test_work_of_a_moved_probe_is_stored_or_lost_and_nothing_else(tool, friction):
    text = struck(tool=tool, friction=friction, damping="0.5 s/m", forces="1 ms")
    played = play(text)
    _, energies = played.energies()
    assert energies["work"].max() > 1e-5
    assert energies["dissipated"][-1] > 0.01 * energies["work"].max()
    assert gap_of_balance(played) < 1e-5


def test_work_of_a_turned_plate_and_a_turned_rod_is_stored_or_lost_as_well():
    tools = """tool probe { kind is plane; point = (0, 0, -10.2) mm; normal = (0.1, 0, 1) }
tool rod { kind is probe; radius = 3 mm; axis from (10, 0, 13) mm to (40, 0, 16) mm }"""
    text = struck(friction="0.3", damping="0.5 s/m", forces="1 ms")
    text = text.replace(
        "tool probe { kind is probe; radius = 5 mm; centre = (0, 0, 18) mm }", tools
    )
    turns = """from 0 s to 40 ms: turn rod by -20 deg around (0, -1, 0)
    through (40, 0, 16) mm using smooth profile
  from 0 s to 40 ms: turn probe by 15 deg around (0, 1, 0)
    through (30, 0, -10) mm using smooth profile"""
    move = "from 0 s to 40 ms: move probe by (2, 1, -12) mm using smooth profile"
    played = play(text.replace(move, turns))
    _, energies = played.energies()
    assert energies["work"].max() > 1e-5
    assert gap_of_balance(played) < 1e-5


def test_both_tiers_move_what_is_touched_alike(monkeypatch):
    text = struck(friction="0.5", damping="0.5 s/m", forces="0.5 ms")
    text = text.replace("duration = 60 ms", "duration = 15 ms")
    text = text.replace("tolerance = 1e-6", "tolerance = 1e-7")
    one = play(text)
    monkeypatch.setattr(engine, "default_backend", lambda integrator: "interpreted")
    other = play(text)
    moved = np.abs(one.position - one.position[0]).max()
    assert np.abs(one.position - other.position).max() < 1e-8 * moved
    (_, first), (_, second) = one.log("force of probe"), other.log("force of probe")
    assert np.abs(first).max() > 0.01
    assert np.abs(first - second).max() < 1e-6 * np.abs(first).max()
    work = one.energies()[1]["work"].max()
    for name, energy in one.energies()[1].items():
        assert energy == pytest.approx(other.energies()[1][name], abs=1e-6 * work)


def pierced(tool, radius):
    """Return the text of a thin sheet, held at its rim, that a probe runs into at 1 m/s."""
    return f"""language 1
tissue thin {{ spring constant = 40 N/m; viscosity = 5 mN*s/m; mass = 5 mg }}
body skin {{
  mesh is sheet {{
    corner = (-10, -10, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 20, 0) mm
    columns = 11; rows = 11; diagonals is both
  }}
  tissue is thin
}}
set rim = nodes of skin where x < -9.9 mm or x > 9.9 mm or y < -9.9 mm or y > 9.9 mm
tool probe {{ kind is probe; radius = {radius} mm; {tool} }}
environment {{ gravity = (0, 0, 0) m/s^2; contact is tools only }}
script {{
  at 0 s: fix rim
  from 0 s to 8 ms: move probe by (0, 0, -8) mm using constant speed
}}
simulate {{ duration = 8 ms }}
output {{ trajectory every 0.1 ms; force of probe every 0.1 ms }}
"""


@pytest.mark.parametrize(
    ("tool", "radius"),
    [
        ("centre = (0.3, 0.2, 3.5) mm", 3.0),
        ("axis from (-4, 0.3, 3) mm to (4, 0.3, 3) mm", 2.0),
    ],
)
def test_no_node_of_a_thin_sheet_passes_a_probe_that_comes_at_a_metre_per_second(tool, radius):
    played = play(pierced(tool, radius))
    assert played.outcome.kind == "done"
    _, force = played.log("force of probe")
    assert force[-1, 2] < -0.1  # the sheet still holds it up
    network = played.compiled.network
    place, ends = (
        played.position[:, nodes] for nodes in (bodies(played), network.tools[0].nodes)
    )
    line = ends[:, 1] - ends[:, 0]
    square = np.maximum((line**2).sum(axis=1), 1e-30)[:, None]
    reach = place - ends[:, :1]
    along = np.clip((reach * line[:, None]).sum(axis=2) / square, 0.0, 1.0)
    apart = 1e3 * (reach - along[..., None] * line[:, None])
    assert np.linalg.norm(apart, axis=2).min() > 0.7 * radius
    below = np.linalg.norm(apart[..., :2], axis=2) < 0.7 * radius
    assert below.any(axis=1).all()
    assert apart[below][:, 2].max() < 0.0


LIFTED = """language 1
tissue band { spring constant = 100 N/m; viscosity = 0.05 N*s/m; mass = 20 mg }
body strip {
  mesh is sheet { corner = (-20, -3, 0) mm; first edge = (40, 0, 0) mm
    second edge = (0, 6, 0) mm; columns = 21; rows = 4; diagonals is both }
  tissue is band
}
tool retractor {
  kind is hook; radius = 1 mm
  shaft from (0, 6, 20) mm to (0, 6, -1.2) mm; bend = (0, -9, -1.2) mm; tip = (0, -9, 4) mm
}
set ends = nodes of strip where abs(x) > 19 mm
set middle = nodes of strip where abs(x) < 1 mm
environment { gravity = (0, 0, 0) m/s^2; damping = 2 mN*s/m; contact is tools only }
script {
  at 0 s: fix ends
  from 0 s to 0.2 s: move retractor by (0, 0, 8) mm using smooth profile
}
simulate { duration = 0.5 s; tolerance = 1e-4 }
output {
  trajectory every 100 ms; force of retractor every 10 ms; force of ends every 10 ms
  torque of retractor every 10 ms; position of retractor every 10 ms
}
"""


def test_a_hook_lifts_the_band_in_its_bend_and_is_twisted_by_the_lever_of_the_lift():
    played = play(LIFTED)
    middle = np.abs(played.compiled.network.position[bodies(played), 0]) < 1e-3
    height = played.position[-1, bodies(played)][middle, 2]
    # The bend's top has come to 8 - 1.2 + 1 mm; the band lies on it, pressed in by the layer.
    assert height == pytest.approx(7.8e-3, abs=3e-4)
    (_, pull), (_, held) = played.log("force of retractor"), played.log("force of ends")
    # At rest what the surgeon lifts with is what the ends are held back with.
    assert pull[-1, 2] > 0.05
    assert pull[-1] == pytest.approx(-held[-1], abs=1e-3 * pull[-1, 2])
    # It pulls the band up along y = 0, which is 1.5 mm aside of the mean of its own points.
    _, twist = played.log("torque of retractor")
    assert twist[-1] == pytest.approx([1.5e-3 * pull[-1, 2], 0.0, 0.0], abs=2e-5 * pull[-1, 2])
