"""Mistakes where elements meet what is made for springs: the way out is named, and works."""

import re

import numpy as np
import pytest

import tissuec
from tests.findings import finding_of
from tests.glue.test_fibres_and_walls import LIVER
from tests.validate.scenes import compiled_scene
from tissuec.core.source import Source
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

SCENE = """language 1
tissue gel { Young's modulus = 5 kPa; density = 1000 kg/m^3; retardation time = 2 ms }
body block {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 20, 10) mm }
  tissue is gel
}
set base = nodes of block where z == 0 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix base }
simulate { duration = 1 ms }
"""
SPRINGS = """language 1
use "tissues/NAME"
body block { mesh is MESH; tissue is NAME MORE }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""
CUBES = "lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 20, 10) mm }"
SHEET = """sheet { corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 9, 0) mm
  columns = 5; rows = 3; diagonals is both }"""


def changed(old, new):
    assert old in SCENE
    return SCENE.replace(old, new)


def springs(name, mesh, more=""):
    return SPRINGS.replace("NAME", name).replace("MESH", mesh).replace("MORE", more)


def warnings(text):
    return compile_request(Request(Source("scene.tis", text)))[1]


@pytest.mark.parametrize(
    ("text", "said", "hint"),
    [
        (springs("liver", CUBES), "for liver, which describes springs", 'use "matter/liver"'),
        (springs("skin", SHEET, "; made of elements"), "skin describes springs",
         'use "matter/skin"'),
        (changed("tissue is gel\n", "tissue is gel; rupture = yes\n"), 'use "is" to choose',
         'write "rupture is allowed"'),
        (changed("tissue gel {", "material gel {"), '"material" does not begin',
         'did you mean "tissue"?'),
        (changed("fix base", "inflate block by 5 ml"), 'does not take "by"', "to 5 ml"),
        (changed("(20, 20, 10) mm", "(20, 20, 10) m"), "would have about", "in mm, not in m?"),
        (SCENE + "script { at 0.5 ms: free base }", "script is given twice",
         "move its contents to the end of the first script"),
        (changed("fix base", "sew base to base"), '"sew" is not a verb', "joint NAME {"),
        (changed("tissue is gel\n", "tissue is gel; prestress across (0, 0, 1); "
                 "prestress = 5 %\n"),
         "the prestress is a formula of x, y or z", "belongs in its tissue"),
    ],
)  # fmt: skip
def test_a_mistake_is_answered_with_a_way_out(text, said, hint):
    found = finding_of(compiled_scene, text)
    assert said in found.message and hint in found.hint


def test_the_ways_out_are_right():
    matter = 'use "matter/liver"'
    compiled_scene(springs("liver", CUBES).replace('use "tissues/liver"', matter))
    compiled_scene(springs("liver", CUBES.replace("cell", "kind is sodium chloride; cell")))
    of_elements = springs("skin", SHEET, "; made of elements; thickness = 1 mm")
    of_elements = of_elements.replace("; diagonals is both", "").replace("tissues/", "matter/")
    assert compiled_scene(of_elements).network.of_kind("membranes")
    tears = changed("tissue is gel\n", "tissue is gel; rupture is allowed\n")
    compiled_scene(tears.replace("density", "breaking strain = 80 %; density"))


@pytest.mark.parametrize(
    ("order", "said"),
    [
        ("cut block along stroke from (6, 6, 12) mm to (6, 9, 12) mm by (0, 0, -14) mm",
         "crosses no edge of a cell of block"),
        ("cut block along plane through (40, 0, 0) mm facing (1, 0, 0)", "does not reach"),
        ("cut block along stroke from (6, 4, 12) mm to (6, 9, 12) mm by (0, 0, -14) mm", ""),
    ],
)  # fmt: skip
def test_a_cut_that_cuts_nothing_is_reported_with_the_reason(order, said):
    for text in (changed("fix base", order), changed("fix base", f"{{ fix base; {order} }}")):
        found = [one.message for one in warnings(text) if one.code == "W410"]
        assert len(found) == bool(said) and all(said in one for one in found)


def test_scissors_that_cut_nothing_feel_nothing(tmp_path):
    order = "from 0 s to 1 ms: cut block along line from (6, 30, 0) mm to (6, 40, 0) mm " \
            "facing (1, 0, 0) with shears"  # fmt: skip
    text = changed("at 0 s: fix base", f"at 0 s: fix base; {order}")
    text = text.replace("density", "cutting resistance = 200 J/m^2; density")
    text += "tool shears { kind is scissors }\noutput { force(shears) every 0.1 ms }\n"
    run = tissuec.run(text, out=tmp_path / "cut.vtkhdf", companion="off")
    assert not run.logs["force of shears"].value.any()


def test_a_plane_with_the_wrong_normal_is_named():
    plane = "tool floor { kind is plane; point = (0, 0, -0.1) mm; normal = (0, 0, SIGN1) }\n"
    text = changed("m/s^2 }", "m/s^2; contact is tools only; friction = 0 }") + plane
    (found,) = [one for one in warnings(text.replace("SIGN", "-")) if one.code == "W406"]
    assert "block lies behind floor" in found.hint and "reverse the normal" in found.hint
    assert not [one for one in warnings(text.replace("SIGN", "")) if one.code == "W406"]


@pytest.mark.parametrize(
    ("vector", "right"),
    [
        ("(9.81 * sin(30 deg), 0, 0) m/s^2", (4.905, 0.0, 0.0)),
        ("(9.81 * sin(tilt), 0, -9.81 * cos(tilt)) m/s^2", (4.905, 0.0, -9.81 * 0.75**0.5)),
        ("(half(2), -sqrt(4), half(30 deg) * 12 / pi) m/s^2", (1.0, -2.0, 1.0)),
        ("(ratio, 2 * ratio, 1 mm/s^2) m/s^2", (3.0, 6.0, 1e-3)),
    ],
)
def test_a_unit_behind_a_vector_is_that_of_all_plain_numbers(vector, right):
    text = changed("(0, 0, 0) m/s^2", vector)
    text += "let tilt = 30 deg\nlet half(x) = x / 2\nparam ratio = 3\n"
    assert compiled_scene(text).plan.gravity == pytest.approx(np.array(right))


def test_an_angle_does_not_become_a_length():
    found = finding_of(compiled_scene, changed("(20, 20, 10) mm", "(20, 30 deg, 10) mm"))
    assert "this vector mixes" in found.message


SPRUNG = LIVER.replace("@C", "9").replace("@R", "5").replace("ratio = 0;", "ratio = 0.45;")
SPRUNG = SPRUNG.replace(
    "joint bond { glue from cover to liver }",
    """tissue glue { spring constant = 20 kN/m; viscosity = 0.1 N*s/m }
set top = nodes of liver where z == 10 mm
joint seam { springs from cover to top; pairs is nearest; tissue is glue }""",
)


def test_a_capsule_is_glued_to_a_solid_as_the_message_says():
    matter = SPRUNG.replace("tissue is glue", "tissue is capsule; section = 25 mm^2")
    matter = re.sub("tissue glue .*\n", "", matter)
    found = finding_of(compiled_scene, matter)
    assert "zero length" in found.message and "spring constant, such as 20 kN/m" in found.hint
    run = tissuec.run(SPRUNG, companion="off")
    # Bars beside each other bear 10 mN; ends that do not narrow add some per cent.
    assert run.logs["force of right"].value[-1][0] == pytest.approx(10.3e-3, abs=0.5e-3)
