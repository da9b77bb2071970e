"""Bodies like others: what they inherit, what is in its place, and what is moved."""

import numpy as np
import pytest

from tests.findings import finding_of
from tests.validate.scenes import compiled_scene
from tissuec.core.source import Source
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

SCENE = """language 1
tissue gel { spring constant = 1 N/m; viscosity = 1 N*s/m; mass = 1 g }
tissue fat { spring constant = 2 N/m; viscosity = 1 N*s/m; mass = 2 g }
body rib {
  mesh is sheet { corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = (0, 10, 0) mm
    columns = 9; rows = 3; diagonals is both }
  tissue is gel
  region tip where x > 31 mm { tissue is fat }
  interface is mean
  moved by (1, 0, 0) mm
}
BODIES
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 s }
"""


def bodies(text, *overrides):
    request = Request(Source("scene.tis", SCENE.replace("BODIES", text)), overrides=overrides)
    compiled, _ = compile_request(request)
    return compiled, compiled.groups.bodies


def test_a_body_like_another_differs_in_what_it_says():
    compiled, found = bodies("body copy like rib { tissue is fat; moved by (0, 20, 0) mm }")
    rib, copy = (found[name].drawing for name in ("rib", "copy"))
    assert np.array_equal(copy.mesh.ends, rib.mesh.ends)
    assert copy.mesh.position - rib.mesh.position == pytest.approx(
        np.tile([0.0, 0.02, 0.0], (27, 1)), abs=1e-15
    )
    assert np.array_equal(copy.part, rib.part) and rib.part.any()
    parts = compiled.network.bodies
    assert set(compiled.network.mass[parts[1].nodes].tolist()) == {2e-3}


def test_likeness_can_be_in_a_row_and_above_what_it_needs():
    text = "body third like second { moved by (0, 1, 0) mm }\n"
    text += "body second like rib { moved by (0, 2, 0) mm }"
    _, found = bodies(text)
    low = [found[name].drawing.mesh.position[0].tolist() for name in ("rib", "second", "third")]
    assert np.array(low) == pytest.approx(1e-3 * np.array([[1, 0, 0], [1, 2, 0], [1, 3, 0]]))


def test_what_is_set_in_one_body_is_set_in_those_like_it():
    _, found = bodies("body copy like rib { }", "rows of rib = 4")
    assert [len(one.drawing.mesh.position) for one in found.values()] == [36, 36]


def test_tables_are_shared():
    text = """
body net { mesh is explicit; tissue is gel }
table nodes of net in mm with columns "id x" { 1 0; 2 5; 3 6 }
table springs of net with columns "a b" { 1 2; 2 3 }
body net 2nd like net { turned by 90 deg around (0, 0, 1) }
table springs of third with columns "a b" { 1 3 }
body third like net { }
""".replace("net 2nd", "turned net")
    _, found = bodies(text)
    assert found["turned net"].drawing.mesh.position[1].tolist() == [0.0, 0.005, 0.0]
    assert found["third"].drawing.mesh.ends.tolist() == [[0, 2]]


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        ("body a like b { }; body b like a { }", "TIS506", "circular definition of bodies"),
        ("body a like rob { }", "TIS301", 'there is no body called "rob"'),
        ("body a like [rib] { }", "TIS312", "body takes one name after like"),
        ("body a from rib { }", "TIS312", "write body a like rib"),
        ("body a extends rib { }", "TIS312", "write body a like rib"),
    ],
)
def test_likeness_that_cannot_be(text, code, words):
    found = finding_of(bodies, text)
    assert found.code == code and words in str(found)


def test_a_mistake_is_reported_where_it_is_and_not_in_the_copies():
    text = SCENE.replace("tissue is gel\n", "tissue is gal\n")
    text = text.replace("BODIES", "body a like rib { }\nset far = nodes of a where x > 1 mm")
    found = finding_of(compiled_scene, text)
    assert found.code == "TIS301" and found.span.line == 7
