"""Friction that tissues give: of each region, and of two tissues the smaller one."""

import numpy as np
import pytest

from tests.contact.scenes import TRIANGLE, contact_with, gap_of_balance, play
from tests.derivatives import forces
from tests.validate.scenes import compiled_scene, validated
from tests.whole_runs import same_when_resumed

GEL = """Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 10 ms"""

# --- two points on a floor --------------------------------------------------------------------

DRAGGED = """language 1
tissue smooth {{ spring constant = 1 N/m; viscosity = 0 N*s/m; mass = 1 g; friction = 0.2 }}
tissue rough like smooth {{ friction = 0.5 }}
body pair {{
  mesh is explicit; tissue is smooth; region far where x > 5 mm {{ tissue is rough }}
  interface is mean
}}
table nodes of pair with columns "id x in mm y in mm z in mm" {{ 1 0 0 -0.2; 2 10 0 -0.2 }}
set one = nodes of pair where id == 1
set two = nodes of pair where id == 2
tool floor {{ kind is plane; point = (0, 0, 0) mm; normal = (0, 0, 1) }}
environment {{
  gravity = (0, 0, 0) m/s^2; contact is tools only; contact stiffness = 1 N/mm
  contact layer = 0.1 mm; {more}
}}
script {{ from 0 s to 1 s: move pair by (2, 0, 0) mm using constant speed }}
simulate {{ duration = 1 s; tolerance = 1e-6 }}
output {{ force of one every 10 ms; force of two every 10 ms }}
"""
PRESSURE = 1e3 * (0.2e-3 - 0.05e-3)


@pytest.mark.parametrize(
    ("more", "expected"),
    [("", (0.2, 0.5)), ("friction = 0.3", (0.3, 0.3)), ("friction = 0", (0.0, 0.0))],
)
def test_each_node_has_the_friction_of_its_tissue_unless_the_environment_has_one(
    more, expected
):
    played = play(DRAGGED.format(more=more))
    for name, friction in zip(("one", "two"), expected, strict=True):
        along = played.log(f"force of {name}")[1][-1, 0]
        assert along == pytest.approx(friction * PRESSURE, abs=1e-6 * PRESSURE)


def test_tissues_without_friction_need_no_bristles():
    text = DRAGGED.format(more="").replace("friction = 0.2", "friction = 0")
    assert compiled_scene(text).network.contact.rubs
    for none in (text.replace("friction = 0.5", ""), DRAGGED.format(more="friction = 0")):
        assert not compiled_scene(none).network.contact.rubs


# --- faces of two regions ---------------------------------------------------------------------

STROKED = f"""language 1
tissue smooth {{ {GEL}; friction = 0.1 }}
tissue rough like smooth {{ friction = 0.4 }}
body block {{
  mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to (20, 5, 5) mm }}
  tissue is smooth
  region far where x > 10 mm {{ tissue is rough }}
}}
tool plate {{ kind is plane; point = (0, 0, 5.1) mm; normal = (0, 0, -1) }}
environment {{ gravity = (0, 0, 0) m/s^2; contact is tools only }}
script {{
  at 0 s: fix block
  from 0 s to 10 ms: move plate by (0, 0, -0.3) mm using smooth profile
  from 10 ms to 20 ms: move plate by (2, 0, 0) mm using smooth profile
}}
simulate {{ duration = 20 ms; tolerance = 1e-4 }}
output {{ force of plate every 1 ms; energy every 1 ms }}
"""


def test_a_tool_across_two_regions_has_two_frictions():
    played = play(STROKED)
    along, _, normal = played.log("force of plate")[1][-1]
    # Two of the four cells, which all bear the same, are of each tissue.
    assert abs(along) == pytest.approx(0.5 * (0.1 + 0.4) * abs(normal), rel=1e-9)
    network = compiled_scene(STROKED).network
    contact, nodes = network.contact, network.body_nodes
    place = contact.between.behind(network.position)[network.node_count :, 0]
    assert np.array_equal(contact.node_friction[nodes:], np.where(place < 10e-3, 0.1, 0.4))
    # A node between two regions is half of each.
    middle = np.flatnonzero(network.position[:nodes, 0] == 10e-3)
    assert contact.node_friction[middle] == pytest.approx(np.full(len(middle), 0.25))


def test_the_energy_balance_closes_while_a_plate_rubs_two_regions():
    assert gap_of_balance(play(STROKED)) < 1e-5


#: The same with a surface that moves.
SOFT = STROKED.replace("fix block", "fix base") + "set base = nodes of block where z == 0 mm\n"


def test_two_frictions_at_once_are_validated():
    text = DRAGGED.format(more="").replace("duration = 1 s", "duration = 0.3 s")
    assert validated(text.replace("tolerance = 1e-6", "tolerance = 1e-4")).verdict == "kept"


@pytest.mark.parametrize("count", [2, 5])
def test_a_run_that_is_resumed_gives_the_same_bytes(count):
    compiled = compiled_scene(SOFT.replace("output {", "output { trajectory every 2 ms;"))
    same_when_resumed(compiled, "force of plate", count)


# --- one tissue on another --------------------------------------------------------------------

SLIDING = """language 1
tissue slab {{ {gel}; friction = {below} }}
tissue block {{ {gel}; friction = {above} }}
body base {{ mesh is lattice {{ cell = 10 mm; box from (-10, -10, -10) mm to (60, 30, 0) mm }}
  tissue is slab }}
body load {{ mesh is lattice {{ cell = 20 mm; box from (0, 0, 1) mm to (20, 20, 21) mm }}
  tissue is block }}
environment {{
  gravity = ({x:.12f}, 0, {z:.12f}) m/s^2; contact is bodies too; contact thickness = 1 mm
}}
script {{ at 0 s: fix base }}
simulate {{ duration = {duration} s; tolerance = 1e-3 }}
output {{ position of load every 5 ms }}
"""


def slid(degrees, duration, above, below):
    """Return times [s] and ways [m] of a block on a slab, both tilted towards x."""
    angle = np.arctan(0.3) + np.radians(degrees)
    text = SLIDING.format(
        gel=GEL, above=above, below=below, duration=duration,
        x=9.81 * np.sin(angle), z=-9.81 * np.cos(angle),
    )  # fmt: skip
    time, rows = play(text).log("position of load")
    return time, rows[:, 0] - rows[0, 0]


@pytest.mark.parametrize(("above", "below"), [(0.3, 0.7), (0.7, 0.3)])
def test_a_block_slides_on_a_slab_beyond_the_angle_of_the_smoother_one(above, below):
    time, way = slid(3.0, 0.25, above, below)
    late = time > 0.1
    angle = np.arctan(0.3) + np.radians(3.0)
    expected = 9.81 * (np.sin(angle) - 0.3 * np.cos(angle))
    acceleration = 2.0 * np.polyfit(time[late], way[late], 2)[0]
    assert acceleration == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(("above", "below"), [(0.3, 0.7), (0.7, 0.3)])
def test_a_block_stays_on_a_slab_below_the_angle_of_the_smoother_one(above, below):
    time, way = slid(-1.0, 0.6, above, below)
    assert np.ptp(way[time > 0.4]) < 1e-5 * 20e-3


def test_a_surface_without_friction_takes_no_part_in_that_of_another():
    """A node between a rough and a smooth face is rubbed by the rough one alone."""
    corners = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
    away = np.array([0.0, 0.0, 0.08])
    position = np.concatenate(
        [np.zeros((1, 3)), corners - away, corners + away, np.zeros((1, 3))]
    )
    faces = np.array([[1, 2, 3], [4, 5, 6]])
    rough = np.array([0.0, 0.5, 0.5, 0.5, 0.0, 0.0, 0.0])
    contact = contact_with(TRIANGLE, faces, 1, friction=0.3, rough=rough, surface=np.arange(2))
    velocity = np.zeros_like(position)
    velocity[contact.memory] = contact.rate * np.array([0.1, 0.0, 0.0])
    found = forces(contact, position, velocity)
    below, above = (found[face].sum(axis=0) for face in faces)
    assert below[2] == pytest.approx(-above[2]) and below[2] < 0.0
    # The smaller coefficient of node and face, on the rough side alone.
    assert found[0, 0] == pytest.approx(0.3 * below[2], rel=1e-12)
    assert below[0] == pytest.approx(-0.3 * below[2], rel=1e-12)
    assert abs(above[0]) < 1e-15


def test_words_give_friction():
    text = STROKED.replace("friction = 0.1", "described in soft matter; surface is moist")
    text = text.replace("language 1", 'language 1\nuse "fuzzy/soft_matter"')
    contact = compiled_scene(text).network.contact
    assert contact.node_friction.min() == pytest.approx(0.1, rel=1e-12)
