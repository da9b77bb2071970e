"""Bodies that are moved: what is said of them goes with them, and forces turn with them."""

import numpy as np
import pytest

from tests.matter.elastic import scene as piece
from tests.validate.scenes import compiled_scene
from tests.whole_runs import carried_out
from tissuec.core.errors import CompileError
from tissuec.geometry.surfaces.skin import BodySkin
from tissuec.geometry.surfaces.splines import refine_grid, through_nodes

MATTER = "Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 2 ms"
NET = "spring constant = 60 N/m; density = 1000 kg/m^3; retardation time = 2 ms"
SPRINGS = "spring constant = 1 N/m; viscosity = 1 N*s/m; mass = 1 g"
BLOCK = (
    "mesh is lattice { kind is sodium chloride; reach is second neighbours; cell = 5 mm; "
    "box from (0, 0, 0) mm to (10, 15, 20) mm }"
)
FINE = "kind is sodium chloride; cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 20) mm"
WALL = "axis from (0, 0, 0) mm to (0, 0, 20) mm; inner radius = 4 mm; outer radius = 6 mm"
DUCT = "axis from (0, 0, 0) mm to (0, 0, 20) mm; radius = 4 mm; rings = 6; sides = 10"
ENTRIES = {
    "turned": "turned by 40 deg around (1, 2, 2) through (3, 0, 1) mm",
    "mirrored": "mirrored about plane through (1, 0, 0) mm facing (1, 2, 2)",
    "both": "turned by 1.2 around (0, 3, 4); mirrored about plane facing (2, 1, 2); "
    "moved by (1, 2, 3) mm",
}
BODIES = {
    "springs with regions": (
        f"{BLOCK}; interface is mean; region tip where z > 14 mm "
        "{ prestress = 3 % }; springs where length > 6 mm and x > 6 mm { prestress = -2 % }",
        NET,
    ),
    "elements with regions": (
        f"mesh is lattice {{ {FINE} }}; fibres = (1, 0, 1); second fibres = (0, 1, 1); "
        "prestress across (0, 0, 1); region tip where z > 9 mm { prestress = 4 % }",
        f"{MATTER}; Poisson's ratio = 0.4; fibre modulus = 40 kPa",
    ),
    "thick tube with helical fibres": (
        f"mesh is thick tube {{ {WALL}; rings = 5; sides = 8; layers = 1 }}; fibres = 35 deg",
        f"{MATTER}; Poisson's ratio = 0.4; fibre modulus = 40 kPa",
    ),
    "wall with helical fibres": (
        f"mesh is tube {{ {DUCT} }}; thickness = 1 mm; made of elements; fibres = 35 deg",
        f"{MATTER}; fibre modulus = 40 kPa",
    ),
    "wall of springs": (
        f"mesh is tube {{ {DUCT}; diagonals is both }}; thickness = 1 mm; bending is soft",
        NET,
    ),
    "graded elements": (
        f"mesh is lattice {{ {FINE} }}; Young's modulus = 5 kPa + z * 400 Pa / 1 mm",
        f"{MATTER}; Poisson's ratio = 0.3",
    ),
    "thread": (
        "mesh is thread { line from (0, 0, 0) mm to (0, 9, 20) mm; pieces = 8; "
        "thickness = 1 mm }; bending is soft",
        "spring constant = 50 N/m; viscosity = 0.1 N*s/m; mass = 10 mg",
    ),
}  # fmt: skip


def resting_scene(body, tissue, placement):
    """Return the compiled scene of a body on which nothing acts."""
    return compiled_scene(
        f"language 1\ntissue gel {{ {tissue} }}\n"
        f"body piece {{ {body}; tissue is gel; {placement} }}\n"
        "environment { gravity = (0, 0, 0) m/s^2 }\nsimulate { duration = 1 s }\n"
    )


def hanging(body, tissue, placement="", gravity=(0.0, -4.0, 6.0)):
    """Return the compiled scene of a body that hangs by its first nodes, and where it rests."""
    text = f"""language 1
tissue gel {{ {tissue} }}
body piece {{ {body}; tissue is gel; {placement} }}
set base = nodes of piece in [1, 2, 3, 4, 5, 6]
environment {{ gravity = {tuple(float(g) for g in gravity)} m/s^2; mass damping = 20 Hz }}
script {{ at 0 s: {{ fix base; settle }} }}
simulate {{ duration = 2 us; integrator is dop853 }}
output {{ trajectory every 1 us }}
"""
    compiled = compiled_scene(text)
    _, recording = carried_out(compiled)
    return compiled, recording.frame_arrays()[1][-1]


RESTING = {}


def resting(name):
    if name not in RESTING:
        RESTING[name] = hanging(*BODIES[name])
    return RESTING[name]


@pytest.mark.parametrize("entries", ENTRIES.values(), ids=ENTRIES)
@pytest.mark.parametrize("name", BODIES)
def test_a_body_rests_as_before_in_gravity_that_is_moved_with_it(name, entries):
    _, before = resting(name)
    body, tissue = BODIES[name]
    placement = resting_scene(body, tissue, entries).groups.bodies["piece"]
    placement = placement.drawing.body.placement
    gravity = placement.matrix @ np.array([0.0, -4.0, 6.0])
    _, after = hanging(body, tissue, entries, gravity)
    drawn = np.ptp(before, axis=0).max()
    assert after == pytest.approx(placement.points(before), abs=2e-6 * drawn)


@pytest.mark.parametrize("kind", ["sodium chloride", "braced cubes"])
def test_springs_of_a_moved_lattice_are_exactly_those_of_the_lattice(kind):
    block = BLOCK.replace("kind is sodium chloride", f"kind is {kind}")
    plain, _ = piece(NET, block)
    for entries in ENTRIES.values():
        moved, _ = piece(NET, f"{block}; {entries}")
        assert np.array_equal(moved.springs.stiffness, plain.springs.stiffness)
    twice, _ = piece(NET, f"{block}; scaled by 2")
    assert twice.mass.sum() == pytest.approx(8.0 * plain.mass.sum(), rel=1e-12)


def test_a_mesh_moves_beneath_what_its_body_says_and_a_body_moves_with_it():
    """In the mesh block, regions and fibres are those of the place where the mesh is then."""
    text = """language 1
tissue gel { Young's modulus = 10 kPa; fibre modulus = 30 kPa; density = 1000 kg/m^3 }
body piece {
  mesh is lattice {
    kind is sodium chloride; cell = 5 mm; box from (0, 0, 0) mm to (5, 5, 20) mm; INNER
  }
  tissue is gel; fibres = (0, 0, 1)
  region tip where z >= 15 mm { prestress = 3 % }
  OUTER
}
set tip = nodes of piece where region is tip
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 s }
"""
    alone = "turned by 180 deg around (1, 0, 0) through (0, 0, 10) mm"
    turn = f"{alone}; turned by 90 deg around (1, 0, 0)"
    inner = compiled_scene(text.replace("INNER", alone).replace("OUTER", ""))
    outer = compiled_scene(text.replace("INNER", "").replace("OUTER", turn))

    def tip(compiled):
        return next(g for g in compiled.groups.named() if g.name == "tip").indices

    drawing = inner.groups.bodies["piece"].drawing
    assert drawing.mesh.position[tip(inner), 2] == pytest.approx(
        np.clip(drawing.mesh.position[tip(inner), 2], 0.015, None)
    )
    assert drawing.body.fibres.tolist() == [0.0, 0.0, 1.0]
    drawing = outer.groups.bodies["piece"].drawing
    # At z = 15 and 20 mm, which come to 5 and 0 mm, and then to y = -5 and 0 mm.
    assert set(np.round(drawing.mesh.position[tip(outer), 1], 9).tolist()) == {-0.005, -0.0}
    assert np.abs(drawing.body.fibres).tolist() == [0.0, 1.0, 0.0]


def test_entries_follow_one_another_as_written():
    def corner(entries):
        compiled = compiled_scene(
            f"language 1\ntissue gel {{ {SPRINGS} }}\n"
            "body piece { mesh is explicit; tissue is gel; " + entries + " }\n"
            'table nodes of piece in mm with columns "id x y z" { 1 1 0 0; 2 0 0 0 }\n'
            'table springs of piece with columns "a b" { 1 2 }\n'
            "environment { gravity = (0, 0, 0) m/s^2 }\nsimulate { duration = 1 s }\n"
        )
        return (1e3 * compiled.network.position[0]).tolist()

    turn = "turned by 90 deg around (0, 0, 1)"
    assert corner(f"moved by (1, 0, 0) mm; {turn}") == [0.0, 2.0, 0.0]
    assert corner(f"{turn}; moved by (1, 0, 0) mm") == [1.0, 1.0, 0.0]
    assert corner("scaled by (3, 1, 1) around (0.5, 0, 0) mm") == pytest.approx([2.0, 0.0, 0.0])
    assert corner("mirrored about plane facing (1, 1, 0)") == pytest.approx([0.0, -1.0, 0.0])


def test_rest_lengths_of_tables_are_not_scaled_unnoticed():
    text = """language 1
tissue gel { spring constant = 1 N/m; viscosity = 1 N*s/m; mass = 1 g }
body piece { mesh is explicit; tissue is gel; scaled by 2 }
table nodes of piece in mm with columns "id x" { 1 1; 2 0 }
table springs of piece in mm with columns "a b rest length" { 1 2 1 }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 s }
"""
    with pytest.raises(CompileError, match="rest lengths"):
        compiled_scene(text)
    turned = compiled_scene(text.replace("scaled by 2", "turned by 1 around (0, 1, 0)"))
    assert turned.network.springs.rest.tolist() == [1e-3]


def test_the_smooth_surface_of_a_mirrored_tube_is_its_mirror_image_and_faces_outwards():
    found = []
    for entries in ("", ENTRIES["mirrored"]):
        compiled = resting_scene(f"mesh is tube {{ {DUCT} }}", SPRINGS, entries)
        network = compiled.network
        alive = np.ones(network.entity_count, dtype=bool)
        skin = BodySkin.of(network, network.bodies[0]).at(alive)
        smooth = refine_grid(skin, through_nodes, 2)
        points, triangles = smooth.at(network.position), smooth.triangles
        centre = points.mean(axis=0)
        a, b, c = (points[triangles[:, k]] - centre for k in range(3))
        found.append((points, float(np.einsum("tk,tk->", a, np.cross(b, c)))))
    (plain, volume), (mirrored, same) = found
    assert same == pytest.approx(volume, rel=1e-9) and volume > 0.0
    placement = compiled.groups.bodies["piece"].drawing.body.placement
    assert mirrored == pytest.approx(placement.points(plain), abs=1e-12)
