"""Small scenes as text, compiled for validation."""

from tissuec.core.source import Source
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.validate.validation import validate

ROD = """language 1
tissue strand { spring constant = 40 N/m; viscosity = VISCOSITY; mass = 1 g
                breaking force = 0.06 N }
body rod {
  mesh is explicit
  tissue is strand
  rupture is RUPTURE
}
table nodes of rod in mm with columns "id x y z" {
  1 0 0 0
  2 10 0 0
  3 20 0 0
  4 30 0 0
}
table springs of rod with columns "a b" {
  1 2
  2 3
  3 4
}
set left  = nodes of rod where x < 1 mm
set right = nodes of rod where x > 29 mm
environment { gravity = (0, 0, -9.81) m/s^2; contact is off; damping = 0 N*s/m }
script {
  at 0 s: fix left
  from 0.025 s to 0.075 s: move right by (2, 0, 1) mm using smooth profile
  EXTRA
}
simulate { duration = 0.15 s; METHOD }
output { trajectory of rod every 10 ms; force of right every 5 ms }
"""


def rod(
    *,
    rupture="not allowed",
    viscosity="0.02 N*s/m",
    method="integrator is automatic; tolerance = 1e-4",
    extra="",
):
    """Return the text of a rod of three springs that hangs between two held ends."""
    text = ROD.replace("RUPTURE", rupture).replace("VISCOSITY", viscosity)
    return text.replace("METHOD", method).replace("EXTRA", extra)


def compiled_scene(text):
    return compile_request(Request(Source("scene.tis", text)))[0]


def silent(stage, time):
    """Take progress without a word."""


def validated(text, *, method="DOP853", rtol=None):
    return validate(compiled_scene(text), method=method, rtol=rtol, progress=silent)


def quantity(validation, name):
    return next(q for q in validation.comparison.quantities if q.name == name)


def same_motion(text, within=1e-4):
    """Compare positions and the energy balance of a run with those of SciPy."""
    found = validated(text, rtol=1e-6)
    for name in ("position", "energy balance"):
        assert quantity(found, name).error < within
