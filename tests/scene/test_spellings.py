"""Measures are written in one way: outputs take it, and old spellings become it."""

import numpy as np
import pytest

import tissuec
from tests.validate.scenes import compiled_scene
from tissuec.core.source import Source
from tissuec.lang.printer import format_source
from tissuec.scene.reading.spellings import respelled

SCENE = """language 1
tissue gel {{ Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 2 ms }}
body bar {{
  mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }}; tissue is gel
}}
set left = nodes of bar where x < 0.1 mm
set right = nodes of bar where x > 19.9 mm
environment {{ gravity = (0, 0, -9.81) m/s^2 }}
script {{ at 0 s: fix left }}
simulate {{ duration = 4 ms }}
output {{ {} }}
"""


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("force of left every 1 ms", "force(left) every 1 ms"),
        ("distance of left to right every 1 ms", "distance(left, right) every 1 ms"),
        ("force of [left, right] every 1 ms", "force([left, right]) every 1 ms"),
        ("nodes of bar every 1 ms", "count(nodes of bar) every 1 ms"),
        ("energy every 1 ms", "energy every 1 ms"),
        ("trajectory of bar every 1 ms", "trajectory of bar every 1 ms"),
    ],
)
def test_an_old_output_becomes_a_new_one_of_the_same_name(old, new):
    source = Source("a.tis", SCENE.format(old))
    found = respelled(source)
    assert found.text == SCENE.format(new)
    assert respelled(found) is found
    laid_out = format_source(found)
    assert respelled(Source("a.tis", laid_out)).text == laid_out
    before, after = (compiled_scene(one.text).plan.output for one in (source, found))
    assert [log.name for log in before.logs] == [log.name for log in after.logs]
    assert [log.measure for log in before.logs] == [log.measure for log in after.logs]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("measure p = max(force of left)", "measure p = max(force(left))"),
        ("measure p = position of right along (0, 0, 1) at 1 ms",
         "measure p = position(right along (0, 0, 1)) at 1 ms"),
        ("measure p = mean(force of left along (1, 0, 0)) from 0 s to 1 ms",
         "measure p = mean(force(left along (1, 0, 0))) from 0 s to 1 ms"),
        ("measure p = time of rupture of bar", "measure p = time of rupture of bar"),
    ],
)  # fmt: skip
def test_measures_of_studies_are_written_as_in_conditions(old, new):
    study = f"study s {{ vary tolerance = [1e-3]; {old} }}\n"
    found = respelled(Source("a.tis", SCENE.format("energy every 1 ms") + study))
    assert f"; {new} }}" in found.text


def test_directions_of_fits_stand_in_the_parentheses():
    text = (
        'language 1\nlearn gel { fit = position(tip) along (1, 0, 0) using column "x" in mm }\n'
    )
    found = respelled(Source("a.tis", text)).text
    assert 'fit = position(tip along (1, 0, 0)) using column "x" in mm' in found


def test_a_component_is_logged(tmp_path):
    path = tmp_path / "bar.tis"
    path.write_text(
        SCENE.format("force(left) every 1 ms; force(left along (0, 3, 4)) every 1 ms")
    )
    run = tissuec.run(path)
    whole = run.logs["force of left"].value[:]
    part = run.logs["force of left along (0, 3, 4)"]
    assert part.unit == "N"
    np.testing.assert_allclose(part.value[:, 0], whole @ [0.0, 0.6, 0.8], rtol=1e-12)
    assert np.abs(whole).max() > 0.0
