"""Measures at points of bodies: places and stresses within elements, against closed forms."""

import numpy as np
import pytest

import tissuec
from tests.script.measures.test_stress import BLOCK, BULK, SHEAR
from tests.validate.scenes import compiled_scene
from tissuec.compiler.measures.points import place_of_point
from tissuec.core.errors import CompileError
from tissuec.geometry.elements import MIDDLES, SHAPES
from tissuec.meshes.elements import TRIANGLE
from tissuec.meshes.generators import ElementMesh
from tissuec.script.measures.snapshot import Snapshot

CUBE = np.array([[x, y, z] for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], float)
CORNERS = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
GRID = np.array([[i, j, k] for i in range(3) for j in range(3) for k in range(3)])
#: Nodes of one element of each shape.
DRAWN = {
    "hexahedron": CUBE,
    "tetrahedron": np.concatenate([CORNERS, CORNERS[MIDDLES].mean(axis=1)]),
    "wedge": np.concatenate([CORNERS[:3], CORNERS[:3] + CORNERS[3]]),
    TRIANGLE: CORNERS[:3],
}


@pytest.mark.parametrize("shape", DRAWN)
def test_a_place_and_numbers_that_are_linear_are_reproduced(shape):
    random = np.random.default_rng(2)
    warp = np.eye(3) + 0.2 * random.normal(size=(3, 3))
    position = DRAWN[shape] @ warp.T
    nodes = np.arange(len(position))[None]
    slope = random.normal(size=3)
    point = random.dirichlet(np.ones(len(position))) @ position
    found = place_of_point((ElementMesh(shape, nodes),), position, point)
    assert not found.is_outside
    assert found.weights @ position == pytest.approx(point, abs=1e-12)
    assert found.of_points.sum() == pytest.approx(1.0, rel=1e-12)
    if shape in SHAPES:  # numbers at the points of the element, which are linear in their place
        element = SHAPES[shape]
        if shape == "tetrahedron":
            from tissuec.geometry.elements import TETRAHEDRAL_POINTS

            places = TETRAHEDRAL_POINTS @ position[:4]
        else:
            places = element.lumped @ position
        assert found.of_points @ (places @ slope) == pytest.approx(point @ slope, abs=1e-12)
    away = place_of_point((ElementMesh(shape, nodes),), position, position.max(axis=0) + 1.0)
    assert away.is_outside


def test_the_distance_of_a_point_outside_is_that_from_the_nearest_face():
    found = place_of_point(
        (ElementMesh("hexahedron", np.arange(8)[None]),), CUBE, np.array([0.3, 0.4, 1.25])
    )
    assert found.beside == pytest.approx(0.25, rel=1e-9)


SEEN = """
output {
  position(block at (11, 3, 4) mm) every 1 ms
  stress(block at (11, 3, 4) mm) every 1 ms
  pressure(block at (11, 3, 4) mm) every 1 ms
  strain(block at (11, 3, 4) mm) every 1 ms
  speed(block at (11, 3, 4) mm) every 1 ms
  distance(block at (11, 3, 4) mm, block at (0, 3, 4) mm) every 1 ms
  position(block at (11, 3, 4) mm along (0, 0, 1)) every 1 ms
}
"""


def observed(position_of, text=BLOCK + SEEN):
    compiled = compiled_scene(text)
    state = compiled.plan.start(compiled.network)
    state.position[:] = position_of(compiled.network.position)
    snapshot = Snapshot.of(state)
    return {
        log.name: log.measure.sample(log.subjects, snapshot)
        for log in compiled.plan.output.logs
    }


def test_points_have_the_values_of_an_even_stretch():
    stretch = 1.3
    found = list(observed(lambda x: x * [stretch, 1.0, 1.0]).items())
    bulk = BULK * np.log(stretch) / stretch
    deviator = SHEAR * stretch ** (-5.0 / 3.0) * (stretch**2 - 1.0) / 3.0
    along, across = bulk + 2.0 * deviator, bulk - deviator
    expected = [
        [stretch * 11e-3, 3e-3, 4e-3], [along, across, across, 0.0, 0.0, 0.0], [-bulk],
        [stretch - 1.0], [0.0], [stretch * 11e-3], [4e-3],
    ]  # fmt: skip
    for (_, value), wanted in zip(found, expected, strict=True):
        assert value == pytest.approx(wanted, rel=1e-11, abs=1e-9 * max(map(abs, wanted)))
    assert found[0][0] == "position of block at (11, 3, 4) mm"


def test_strain_varies_within_an_element_as_in_pure_bending():
    """ε_xx = κ z, where u = κ (x z, -ν y z, (ν y² - ν z² - x²)/2), also at faces."""
    curve, ratio = 1e-5, 0.3  # so small that it is linear
    text = BLOCK.replace("cell = 5 mm", "cell = 10 mm")

    def bent(place):
        x, y, z = place.T
        return place + curve * np.column_stack(
            [x * z, -ratio * y * z, 0.5 * (ratio * (y * y - z * z) - x * x)]
        )

    for point in ((5, 5, 6), (15, 2, 7), (5, 5, 10)):
        of_point = text + f"output {{ strain(block at {point} mm) every 1 ms }}"
        (value,) = observed(bent, of_point).values()
        # Edges along x stay straight, which shears points by κ 2.9 mm: with ε_zz = -ν κ 5 mm,
        # the largest principal strain is up to 5 % larger, as 6.27 instead of 6 (times κ 1 mm).
        assert value[0] == pytest.approx(curve * 1e-3 * point[2], rel=0.06)


WALL = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }
tissue cord { spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 50 mg }
body mat {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 9, 0) mm
    columns = 5; rows = 3 }
  tissue is gel; thickness = 1 mm
}
body net {
  mesh is sphere { centre = (0, 0, 60) mm; radius = 5 mm; subdivisions = 1 }; tissue is cord
}
set end = nodes of mat where x == 20 mm
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""


def test_points_of_walls_lie_in_their_triangles():
    point = "(mat at (7, 5, 0) mm) every 1 ms"
    text = f"{WALL} output {{ position{point}; strain{point} }}"
    place, strain = observed(lambda x: x * [1.1, 1.0, 1.0], text).values()
    assert place == pytest.approx([7.7e-3, 5e-3, 0.0], abs=1e-15)
    assert strain == pytest.approx([0.1], rel=1e-12)


@pytest.mark.parametrize(
    ("sentence", "said"),
    [
        ("stress(mat at (25, 5, 0) mm) < 1 Pa", "this point is 5 mm outside of mat as drawn"),
        ("stress(mat at (7, 5, 1) mm) < 1 Pa", "this point is 1 mm outside of mat as drawn"),
        ("position(net at (5, 0, 60) mm) < 1 mm", "a point is one of a body of elements"),
        ("position(end at (20, 0, 0) mm) < 1 mm", "a point is one of a body of elements"),
        ("force(mat at (7, 5, 0) mm) < 1 N", "force(A) has no value at a point"),
        ("stress(mat at 7 mm) < 1 Pa", "a point is a vector with a unit"),
        ("stress(mat at (7, 5, 0)) < 1 Pa", "a point is a vector with a unit"),
        ("largest(speed of mat at (7, 5, 0) mm) < 1 m/s", "the form is largest(FIELD of A)"),
    ],
)
def test_points_that_are_nowhere_are_refused(sentence, said):
    with pytest.raises(CompileError) as caught:
        compiled_scene(f"{WALL}expect {sentence} at 1 ms")
    assert said in str(caught.value)


PULLED = BLOCK.replace("duration = 1 ms", "duration = 0.1 s; integrator is equilibrium")
PULLED += """
set start = nodes of block where x < 0.1 mm
set face = nodes of block where x > 19.9 mm
script {
  at 0 s: fix start
  from 0 s to 0.1 s: move face by (1, 0, 0) mm using constant speed
}
output { position(block at (10, 5, 5) mm) every 50 ms }
expect position(block at (10, 5, 5) mm along (1, 0, 0)) between 10.49 mm and 10.51 mm at 0.1 s
study all {
  vary Young's modulus of gel = [5 kPa, 10 kPa]
  measure middle = stress(block at (10, 5, 5) mm along (1, 0, 0)) at 0.1 s
  measure peak = max(stress(block at (10, 5, 5) mm))
}
"""


def test_points_are_known_to_runs_expectations_and_studies(tmp_path):
    path = tmp_path / "pulled.tis"
    path.write_text(PULLED)
    with tissuec.run(path, out=tmp_path / "w.vtkhdf", companion="off") as result:
        log = result.logs["position of block at (10, 5, 5) mm"]
        assert log.columns == ("x", "y", "z")
        assert log.value[-1] == pytest.approx([10.5e-3, 5e-3, 5e-3], rel=1e-6)
        assert result.outcome.startswith("done")
    table = tissuec.study(path, name="all", out=tmp_path / "table.csv")
    middle = table.column("middle").numbers
    assert middle[1] / middle[0] == pytest.approx(2.0, rel=1e-6)
    assert table.column("peak").numbers == pytest.approx(1.04 * middle, rel=0.01)
