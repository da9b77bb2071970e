"""A hook lifts an organ of elements, which rests on it and does not pass."""

import numpy as np
import pytest

from tests.contact.scenes import play
from tissuec.geometry.sweeps import side_of

LOBE = """language 1
use "matter/liver"
body organ {{
  mesh is lattice {{ cell = 8 mm; box from (0, -16, 0) mm to (64, 16, 16) mm }}
  tissue is liver
}}
set root = nodes of organ where x == 0 mm
tool retractor {{
  kind is hook; radius = {radius} mm
  shaft from (44, -60, {height}) mm to (44, -30, {height}) mm
  bend = (44, 30, {height}) mm
}}
environment {{ gravity = (0, 0, 0) m/s^2; mass damping = 20 Hz; contact is tools only }}
script {{
  at 0 s: fix root
  from 0 s to 0.2 s: move retractor by (0, 0, 15) mm using smooth profile
}}
simulate {{ duration = 0.3 s; tolerance = 1e-2 }}
output {{ trajectory every 10 ms; force of retractor every 5 ms
  penetration of retractor every 5 ms }}
"""
#: The left lobe of the shipped liver, which is held at its bare area.
LIVER = """language 1
use "matter/liver"
# With the ratio of the preset, steps are six times shorter.
tissue parenchyma like liver { Poisson's ratio = 0.49 }
body organ {
  mesh is imported { file "meshes/liver.obj" in mm; filling is tetrahedra; cell = 30 mm }
  tissue is parenchyma
}
set bare area = nodes of organ where group is "bare_area"
tool retractor {
  kind is hook; radius = 6 mm
  shaft from (75, -120, -20) mm to (75, -60, -20) mm; bend = (75, 60, -20) mm
}
environment { gravity = (0, 0, 0) m/s^2; mass damping = 5 Hz; contact is tools only }
script {
  at 0 s: fix bare area
  from 0 s to 0.25 s: move retractor by (0, 0, 20) mm using smooth profile
}
simulate { duration = 0.3 s; tolerance = 1e-2 }
output { trajectory every 10 ms; force of retractor every 5 ms
  penetration of retractor every 5 ms }
"""


def lifted(played, *, radius):
    """Return by how much the underside above the hook rose [m]; the hook is outside.

    Args:
        radius: Of the hook [m].
    """
    assert played.outcome.kind == "done"
    # The thin edge of the liver, of cells of 30 mm, may fold onto itself.
    assert {(one.kind, one.subject) for one in played.outcome.doubts} <= {
        ("bodies overlap", "organ")
    }
    network, position = played.compiled.network, played.position[-1]
    (organ,), (tool,) = network.bodies, network.tools
    skin = network.skin_of(organ)
    start, end = position[tool.nodes][2:4]
    for share in np.linspace(0.0, 1.0, 41):
        place = start + share * (end - start)
        assert side_of(place, position, skin)[0]
    drawn = network.position[organ.nodes]
    near = np.abs(drawn[:, 0] - start[0]) < max(5e-3, radius)
    low = near & (drawn[:, 2] < drawn[near, 2].min() + 2e-3)
    return float((position[organ.nodes] - drawn)[low, 2].mean())


@pytest.mark.parametrize("radius", [1, 6])
def test_a_hook_lifts_a_lobe_and_does_not_pass(radius):
    found = play(LOBE.format(radius=radius, height=-radius - 0.3))
    # The underside rises with the hook, which begins 0.3 mm below it.
    assert 13e-3 < lifted(found, radius=1e-3 * radius) < 16e-3
    force = found.log("force of retractor")[1][:, 2]
    assert 0.09 < force.max() < 0.15 and force[-1] > 0.02
    assert found.log("penetration of retractor")[1].max() < 0.3e-3


@pytest.mark.slow
def test_a_hook_lifts_the_liver_of_the_library_and_does_not_pass():
    found = play(LIVER)
    assert 15e-3 < lifted(found, radius=6e-3) < 20e-3
    force = found.log("force of retractor")[1][:, 2]
    assert 0.3 < force.max() < 0.45 and 0.2 < force[-1] < 0.35
    assert found.log("penetration of retractor")[1].max() < 0.4e-3
