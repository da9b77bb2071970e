"""What a cut costs: areas of cut surfaces, their energy, and the force of blades that close."""

import re

import numpy as np
import pytest

from tests.contact.scenes import play
from tests.validate.scenes import compiled_scene
from tests.whole_runs import same_when_resumed
from tissuec.core.units import parse_unit
from tissuec.geometry.blade_sections import parts_of_lines, shares_of_polygons
from tissuec.mechanics.state import State
from tissuec.model.profiles import TimeProfile
from tissuec.script.verbs.cut_surface import cut_surface, plane, strip, stroke

RESISTANCE = 200.0
FLESH = """language 1
tissue flesh {
  Young's modulus = 10 kPa; density = 1 g/cm^3; retardation time = 10 ms
  cutting resistance = 200 J/m^2
}
"""
BLOCK = """body block {{
  {made}
  mesh is lattice {{ {kind}cell = {cell} mm; box from (0, 0, 0) mm to (20, 10, 10) mm }}
  tissue is flesh
}}
"""
REST = """
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 s }
"""


def block(cell=5, made="", kind=""):
    return FLESH + BLOCK.format(cell=cell, made=made, kind=kind) + REST


def surface(text, blade, change=None):
    """Return the surface of a cut through all bodies of a scene as drawn.

    Args:
        change: What becomes of positions before the cut.
    """
    network = compiled_scene(text).network
    state = State.start(network, gravity=np.zeros(3), drag=0.0)
    if change is not None:
        state.position = change(state.position)
    lines = np.flatnonzero(state.alive_lines & network.of_bodies)
    first, second = state.position[network.line_ends[lines]].swapaxes(0, 1)
    crossed = blade.crosses(first, second, network.extent)[0]
    return cut_surface(state, lines[crossed], blade)


def facing(degrees, through=(9.7e-3, 5e-3, 5e-3), turn=30.0):
    """Return a plane whose normal is so far from the x axis."""
    a, b = np.radians([degrees, turn])
    normal = np.array([np.cos(a), np.sin(a) * np.cos(b), np.sin(a) * np.sin(b)])
    return plane(np.array(through), normal)


@pytest.mark.parametrize("cell", [5, 2.5])
@pytest.mark.parametrize("degrees", [0.0, 17.0, 40.0])
def test_a_cut_through_elements_has_the_area_of_the_blade_within_them(cell, degrees):
    found = surface(block(cell), facing(degrees))
    # Both are perpendicular sections of a long bar: 1 cm^2 over the cosine.
    area = 1e-4 / np.cos(np.radians(degrees))
    assert found.area == pytest.approx(area, rel=1e-12)
    assert found.energy == pytest.approx(RESISTANCE * area, rel=1e-12)


def test_areas_are_those_as_drawn():
    stretched = np.array([1.5, 0.7, 0.8])
    found = surface(block(), plane(np.array([14e-3, 0, 0]), np.array([1.0, 0, 0])),
                    lambda position: position * stretched)  # fmt: skip
    assert found.area == pytest.approx(1e-4, rel=1e-12)


def test_a_stroke_cuts_its_own_area():
    start, stop = np.array([9.7e-3, 3e-3, -5e-3]), np.array([9.7e-3, 9e-3, -5e-3])
    for way in ([0.0, 0.0, 12e-3], [0.0, -2e-3, 12e-3]):
        blade = stroke(start, stop, np.array(way))
        # 6 mm wide from the lower surface to 7 mm above it; it begins 5 mm below.
        found = surface(block(2.5), blade)
        assert found.area == pytest.approx(6e-3 * 7e-3, rel=1e-12)


def test_a_strip_cuts_what_is_between_its_ends():
    blade = strip(
        np.array([9.7e-3, -4e-3, 0.0]), np.array([9.7e-3, 6e-3, 0.0]), np.array([1.0, 0, 0])
    )
    assert surface(block(), blade).area == pytest.approx(6e-3 * 10e-3, rel=1e-12)


@pytest.mark.parametrize(("degrees", "cell"), [(0, 2), (25, 2), (40, 2), (25, 1)])
def test_a_cut_through_a_wall_is_as_long_as_the_blade_in_it(degrees, cell):
    text = FLESH + f"""body wall {{
  mesh is sheet {{
    corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = (0, 10, 0) mm
    columns = {40 // cell + 1}; rows = {10 // cell + 1} }}
  tissue is flesh; thickness = 0.5 mm
}}
""" + REST  # fmt: skip
    found = surface(text, facing(degrees, (19.7e-3, 5e-3, 0.0), turn=0.0))
    assert found.area == pytest.approx(5e-6 / np.cos(np.radians(degrees)), rel=1e-12)


def test_threads_are_cut_by_their_sections():
    text = FLESH.replace("200 J", "100 J") + """
body string {
  mesh is thread { line from (0, 0, 0) mm to (30, 0, 0) mm; pieces = 10; thickness = 2 mm }
  tissue is flesh
}
""" + REST  # fmt: skip
    found = surface(text, facing(35.0, (10.5e-3, 0, 0)))
    assert found.area == pytest.approx(np.pi * 1e-6, rel=1e-12)
    assert found.energy == pytest.approx(1e-4 * np.pi, rel=1e-12)


def test_two_tissues_have_two_resistances():
    text = block().replace("tissue is flesh", "tissue is flesh; region top where z > 5 mm "
                           "{ tissue is fascia }")  # fmt: skip
    text += "tissue fascia like flesh { cutting resistance = 1 kJ/m^2 }\n"
    found = surface(text, facing(0.0))
    assert found.energy == pytest.approx(0.5e-4 * (200.0 + 1000.0), rel=1e-12)
    text = text.replace("cutting resistance = 200 J/m^2", "")
    assert surface(text, facing(0.0)).area == pytest.approx(0.5e-4, rel=1e-12)


def test_tissue_without_a_resistance_costs_nothing():
    text = block().replace("cutting resistance = 200 J/m^2", "")
    assert compiled_scene(text).network.cutting is None
    assert compiled_scene(text.replace("cell = 5", "cell = 5")).network.cutting is None


# --- polygons and lines within a blade --------------------------------------------------------


def test_shares_of_polygons_agree_with_counted_points():
    rng = np.random.default_rng(3)
    for limited in ((True, False), (False, True), (True, True)):
        for _ in range(20):
            turn = np.sort(rng.uniform(0.0, 2.0 * np.pi, 5))
            corners = rng.uniform(0.2, 0.8, 2) + 0.6 * np.stack([np.cos(turn), np.sin(turn)], 1)
            x, y = np.meshgrid(*[np.linspace(-1.0, 2.0, 601)] * 2)
            after = np.roll(corners, -1, axis=0)
            inside = np.ones(x.shape, dtype=bool)
            for (a, b), (c, d) in zip(corners, after, strict=True):
                inside &= (c - a) * (y - b) - (d - b) * (x - a) >= 0.0
            within = inside.copy()
            for values, is_limited in zip((x, y), limited, strict=True):
                if is_limited:
                    within &= (values >= 0.0) & (values <= 1.0)
            found = shares_of_polygons(corners[None], limited)[0]
            assert found == pytest.approx(within.sum() / inside.sum(), abs=0.02)


def test_shares_of_lines_are_the_parts_within_limits():
    lines = np.array([
        [[-1.0, 0.5], [1.0, 0.5]], [[0.5, -0.5], [0.5, 1.0]], [[0.2, 0.2], [0.2, 0.2]],
        [[2.0, 0.0], [3.0, 0.0]], [[-0.5, 0.0], [1.5, 2.0]],
    ])  # fmt: skip
    for limited, shares in (
        ((True, False), [0.5, 1.0, 1.0, 0.0, 0.5]),
        ((True, True), [0.5, 2 / 3, 1.0, 0.0, 0.25]),
    ):
        assert np.diff(parts_of_lines(lines, limited))[:, 0] == pytest.approx(shares)


# --- the force of blades that close -----------------------------------------------------------

SHEET = FLESH + """body wall {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = (0, 20, 0) mm
    columns = 21; rows = 11 }
  tissue is flesh; thickness = 1 mm
}
""" + REST  # fmt: skip
EVERYWHERE = np.linspace(0.0, 1.0, 4001)[:-1]  # contains all sides of elements of the scenes


def closing(text, blade, change=None):
    """Return the surface of a cut, and the force along the line at many shares of it [N]."""
    found = surface(text, blade, change)
    force = found.force("", blade, TimeProfile("ramp", -1e-12, 1.0)).at(EVERYWHERE)
    way = blade.spans[0] / np.linalg.norm(blade.spans[0])
    assert np.cross(force, way) == pytest.approx(0.0, abs=1e-12)
    work = float((force @ way).mean() * np.linalg.norm(blade.spans[0]))
    assert work == pytest.approx(found.energy, rel=2e-3)  # a sum over 4000 moments
    return found, force @ way


def line(start, stop, facing):
    return strip(1e-3 * np.array(start), 1e-3 * np.array(stop), np.array(facing))


@pytest.mark.parametrize("x", [20.0, 21.0, 20.7])
@pytest.mark.parametrize("slant", [0.0, 6.0, 17.0])
@pytest.mark.parametrize("stretch", [1.0, 1.25])
def test_a_blade_through_a_sheet_needs_the_same_force_all_the_way(x, slant, stretch):
    size = np.hypot(22.0, slant)
    blade = line((x, -1, 0), (x + slant, 21, 0), (22.0 / size, -slant / size, 0.0))
    # A prestressed sheet is cut as drawn: the stretch shortens the blade's way through it.
    found, force = closing(SHEET, blade, lambda position: position * [stretch, 1.0, 1.0])
    inside = (EVERYWHERE > 1.001 / 22.0) & (EVERYWHERE < 20.999 / 22.0)
    drawn = np.hypot(slant / stretch, 22.0) / size
    assert force[inside] == pytest.approx(RESISTANCE * 1e-3 * drawn, rel=1e-9)
    assert np.all(force[(EVERYWHERE < 0.999 / 22.0) | (EVERYWHERE > 21.001 / 22.0)] == 0.0)
    assert found.area == pytest.approx(20e-3 * 1e-3 * np.hypot(slant / stretch, 22.0) / 22.0)


@pytest.mark.parametrize("cell", [5, 2.5])
@pytest.mark.parametrize("x", [7.5, 10.0])
@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_a_blade_through_a_solid_needs_the_force_of_its_width_at_every_moment(cell, x, tilt):
    # In the plane x, the block is 10 by 10 mm. A line at a slope of tilt crosses it obliquely:
    # chords at right angles to it grow from 0, are 10 mm over the cosine, and shrink.
    blade = line((x, -5, -5 * tilt), (x, 15, 15 * tilt), (1, 0, 0))
    found, force = closing(block(cell), blade)
    size = np.hypot(1.0, tilt)
    along = np.array([1.0, tilt]) / size
    corners = np.array([(y, z) for y in (0.0, 10.0) for z in (0.0, 10.0)])
    first = (corners - [-5.0, -5.0 * tilt]) @ along
    place = EVERYWHERE * 20.0 * size
    low, high = np.sort(first)[1], np.sort(first)[2]
    rise = low - first.min()
    width = 10.0 * size * np.clip(
        np.minimum(place - first.min(), first.max() - place) / (rise or 1e-9), 0.0, 1.0
    )  # fmt: skip
    if not tilt:
        width = 10.0 * ((place > low) & (place < high))
    near = np.min(np.abs(place[:, None] - first), axis=1) < 1e-6
    assert force[~near] == pytest.approx(RESISTANCE * 1e-3 * width[~near], rel=1e-9, abs=1e-9)
    # A corner of the block may be outside of the strip; the rest of the area is in the force.
    assert found.area == pytest.approx(1e-4, rel=1e-9)


def test_shares_that_differ_by_rounding_are_no_moment_at_which_forces_add_up():
    shaken = 1e-15 * np.random.default_rng(5).normal(size=(10_000, 3))
    blade = line((7.5, -5, 5), (7.5, 15, 5), (1, 0, 0))
    _, force = closing(block(), blade, lambda position: position + shaken[: len(position)])
    inside = (EVERYWHERE > 0.251) & (EVERYWHERE < 0.749)
    assert force[inside] == pytest.approx(RESISTANCE * 10e-3, rel=1e-9)


def test_a_stroke_across_a_solid_needs_the_force_of_what_is_within_it():
    blade = stroke(1e-3 * np.array([7.5, -5, 12]), 1e-3 * np.array([7.5, 15, 12]),
                   1e-3 * np.array([0, 0, -5]))  # fmt: skip
    _, force = closing(block(2.5), blade)  # cells down to z = 7.5 mm; the stroke ends at 7 mm
    inside = (EVERYWHERE > 0.251) & (EVERYWHERE < 0.749)
    assert force[inside] == pytest.approx(RESISTANCE * 3e-3, rel=1e-9)


@pytest.mark.parametrize("turn", [0.0, 9.0, 14.0])
def test_a_blade_across_a_tube_needs_the_force_of_the_width_of_its_ring(turn):
    sides, radius, thick = 16, 10.0, 2.0
    text = FLESH + """body vessel {
  mesh is tube {
    axis from (0, 0, 0) mm to (40, 0, 0) mm; radius = 10 mm; rings = 9; sides = 16 }
  tissue is flesh; thickness = 2 mm
}
""" + REST  # fmt: skip
    angle = np.radians(turn)
    way = np.array([0.0, np.cos(angle), np.sin(angle)])
    blade = line(-12.5 * way + [19, 0, 0], 12.5 * way + [19, 0, 0], (1, 0, 0))
    _, force = closing(text, blade)

    def width(place, apothem):
        """Return the width of a polygon with a corner on the y axis at places along the way."""
        corner = apothem / np.cos(np.pi / sides)
        turns = 2.0 * np.pi * np.arange(sides) / sides
        points = corner * np.stack([np.cos(turns - angle), np.sin(turns - angle)], axis=1)
        low, high = np.full_like(place, np.inf), np.full_like(place, -np.inf)
        for (a, b), (c, d) in zip(points, np.roll(points, -1, axis=0), strict=True):
            there = (place - a) * (place - c) < 0.0
            met = b + (place - a) / (c - a) * (d - b)
            low = np.where(there, np.minimum(low, met), low)
            high = np.where(there, np.maximum(high, met), high)
        return np.where(high > low, high - low, 0.0)

    middle = radius * np.cos(np.pi / sides)
    place = 25.0 * EVERYWHERE - 12.5 + 1e-7  # beside corners
    ring = width(place, middle + thick / 2) - width(place, middle - thick / 2)
    # The area counts the middle line, whose length is that of the ring at its mitres.
    assert force == pytest.approx(RESISTANCE * 1e-3 * ring, rel=1e-4, abs=1e-4)


# --- runs -------------------------------------------------------------------------------------

CUT = """
set ends = nodes of block where x == 0 mm or x == 20 mm
tool shears {{ kind is scissors }}
script {{
  at 0 s: fix ends
  from 0.1 s to 0.9 s: cut block along line from (9.7, {start}, 5) mm to (9.7, {stop}, 5) mm facing (1, 0, 0) with shears using {profile}
}}
output {{ force of shears every 1 ms; trajectory every 0.1 s; energy every 10 ms }}
"""  # noqa: E501


def costs(played):
    """Return the areas [m²] and energies [J] in the log of events."""
    texts = [event.cause for _, event in played.outcome.logged_events if event.kind == "cut"]
    found = [re.search(r"\((\S+) (\S+), (\S+) (\S+)\)$", text) for text in texts]
    pairs = [(one[1], one[2], one[3], one[4]) for one in found if one]
    return np.array([
        (float(a) * parse_unit(b).factor, float(c) * parse_unit(d).factor)
        for a, b, c, d in pairs
    ]).sum(axis=0)  # fmt: skip


@pytest.mark.parametrize("profile", ["constant speed", "smooth profile"])
def test_scissors_feel_the_width_of_the_tissue_and_take_the_energy_of_its_area(profile):
    played = play(block(2.5) + CUT.format(start=-2, stop=8, profile=profile))
    area, energy = costs(played)
    assert area == pytest.approx(8e-3 * 10e-3, rel=5e-3)  # shown with three digits
    assert energy == pytest.approx(RESISTANCE * 8e-3 * 10e-3, rel=5e-3)
    time, force = played.log("force of shears")
    share = np.clip((time - 0.1) / 0.8, 0.0, 1.0)
    if profile != "constant speed":
        share = 10 * share**3 - 15 * share**4 + 6 * share**5
    place = -2e-3 + 10e-3 * share
    inside = (place > 0.1e-3) & (share < 0.999)
    # 10 mm of 200 J/m^2 all the way, along the line.
    assert force[inside] == pytest.approx(np.array([[0.0, 2.0, 0.0]] * inside.sum()), rel=1e-6)
    assert np.all(force[(place < -0.1e-3) | (time > 0.9)] == 0.0)


def test_a_cut_at_once_says_what_it_takes():
    text = (
        block()
        + """
tool shears { kind is scissors }
script { at 0.1 s: cut block along plane through (9.7, 0, 0) mm facing (1, 0, 0) with shears }
"""
    )
    played = play(text)
    (event,) = [event for _, event in played.outcome.logged_events if event.kind == "cut"]
    assert event.cause.endswith("with shears (100 mm^2, 20 mJ)")


def test_a_run_that_is_resumed_during_a_cut_gives_the_same_bytes():
    text = block() + CUT.format(start=-2, stop=8, profile="constant speed")
    text = text.replace("every 1 ms", "every 10 ms")
    _, *parts = same_when_resumed(compiled_scene(text), "force of shears", 12)
    assert all(0.1 < first.state.time < 0.9 for first, _ in parts)
