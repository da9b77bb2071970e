"""Digests of what kernels compute: ``python -m tests.compiled.on_processor SCENE…``.

``TISSUEC_PROCESSOR`` says for which processor the kernels are made.
"""

import json
import sys
from hashlib import sha256

import numpy as np

from tests.contact.test_faces_friction import RUBBED
from tests.inelastic.elements import ONE, PULLED, scene
from tests.validate.scenes import compiled_scene
from tests.whole_runs import carried_out
from tissuec.core.resources import library
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

LAWS = """language 1
tissue rubber {
  spring constant = 200 N/m; viscosity = 0.2 N*s/m; mass = 0.2 g
  spring force of e = c * e * exp(sin(20 * e / rest length))
  viscous force of w = d * w * log(2 + abs(w) / (1 m/s)) * (1 + abs(w) / (1 m/s))^0.3
}
body bar {
  mesh is lattice { kind is sodium chloride; cell = 10 mm; reach is second neighbours
                    box from (0, 0, 0) mm to (30, 10, 10) mm }
  tissue is rubber
}
set low = nodes of bar where x < 1 mm
set high = nodes of bar where x > 29 mm
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix low
  at 0 s: push high with (0, 1, 0.4) N using sine of 20 Hz
}
simulate { duration = 20 ms; tolerance = 1e-6 }
output { trajectory every 1 ms; force of low every 1 ms; energy every 5 ms }
"""
FIBRES = f"{ONE}; fibre modulus = 20 kPa; fibre stiffening = 8"
#: By name: the text of a scene, and a set or tool whose force is logged.
SCENES = {
    "laws": (LAWS, "low"),
    "solid": (
        scene(
            FIBRES,
            body="fibres = (1, 0, 1)",
            script=PULLED.partition("\n  from 40")[0],
            method="integrator is velocity verlet; tolerance = 1e-3",
            duration="30 ms",
        ),
        "high",
    ),
    "contact": (RUBBED.replace("output {", "output { trajectory every 1 ms;"), "ball"),
}


def of_text(text, logged):
    """Return a digest of all that a scene records."""
    outcome, recording = carried_out(compiled_scene(text))
    assert outcome.kind == "done"
    rows = [*recording.frame_arrays(), *recording.log_arrays(f"force of {logged}")]
    return digest([*rows, outcome.state.velocity])


def of_library(stem):
    """Return a digest of where a shipped scene ends."""
    compiled, _ = compile_request(Request.file(library() / "scenes" / f"{stem}.tis"))
    outcome, _ = carried_out(compiled)
    return digest([outcome.state.position, outcome.state.velocity])


def digest(arrays):
    return sha256(b"".join(np.ascontiguousarray(one).tobytes() for one in arrays)).hexdigest()


if __name__ == "__main__":
    found = {
        name: of_text(*SCENES[name]) if name in SCENES else of_library(name)
        for name in sys.argv[1:]
    }
    print(json.dumps(found))
