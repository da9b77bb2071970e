"""The tube published with the method: 160 nodes and 610 springs, pulled, pushed and cut."""

from tissuec.core.source import Source
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

TUBE = """language 1
tissue tube wall {{
  spring constant = 10 N/m; viscosity = 20 mN*s/m; mass = 10 g; prestress = 5 %
}}
tool shears {{ kind is scissors }}
body tube {{
  mesh is tube {{
    axis from (0, 0, 0) mm to (64, 0, 0) mm; radius = 3 mm; rings = 16; sides = 10
    diagonals is none; interior is crossed
  }}
  tissue is tube wall
}}
set left = nodes of tube where x < 1 mm
set right = nodes of tube where x > 63 mm
set middle = nodes of tube where x between 28 mm and 34 mm
environment {{ gravity = (0, 0, -9.81) m/s^2; damping = 0.2 mN*s/m }}
script {{
  at 0 s: fix left
  from 0 s to 20 ms: move right by (2, 3, 0) mm using smooth profile
  from 0 s to 50 ms: push middle with 0.5 N along (0, 0, 1) using ramp
  at 25 ms: cut tube along plane through (44, 0, 0) mm facing (1, 0, 0) with shears
  at 30 ms: release right
  at 40 ms: change spring constant of middle by 50 %
}}
simulate {{ duration = 50 ms }}
{more}
"""


def tube(more=""):
    """Return the compiled scene."""
    return compile_request(Request(Source("tube.tis", TUBE.format(more=more))))[0]
