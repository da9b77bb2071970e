"""What changes nothing, measures something else, or is off the mesh: a block, a wall, a thread.

Each row is a scene with something more, the code of the answer, a part of its message or hint,
and what is written instead by following the hint.
"""

from typing import NamedTuple

SCENE = """language 1
param lift = 2 mm between 0 mm and 5 mm
tissue gel { Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms }
tissue hard like gel { Young's modulus = 40 kPa }
tissue silk { spring constant = 400 N/m; viscosity = 0.1 N*s/m; mass = 20 mg }
body block {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }
  tissue is gel
  BLOCK
}
body flap {
  mesh is sheet {
    corner = (0, 0, 40) mm; first edge = (20, 0, 0) mm; second edge = (0, 10, 0) mm
    columns = 5; rows = 3
  }
  tissue is gel; thickness = 1 mm
  FLAP
}
body suture {
  mesh is thread { line from (0, 0, 60) mm to (20, 0, 60) mm; pieces = 4; thickness = 0.5 mm }
  tissue is silk
  THREAD
}
set base = nodes of block where z == 0 mm
set roof = nodes of block where z == 10 mm
set side = nodes of block where x == 20 mm and z == 5 mm
set rim = nodes of flap where x == 0 mm
set tip = nodes of flap where x == 20 mm
set start = nodes of suture where x == 0 mm
environment { gravity = (0, 0, 0) m/s^2; ENVIRONMENT }
script {
  at 0 s: { fix base; fix rim; fix start }
  from 0 s to 50 ms: move roof by (0 mm, 0 mm, lift) using smooth profile
  SCRIPT
}
simulate { duration = 0.1 s; tolerance = 1e-3 }
output {
  force(roof) every 10 ms; position(tip) every 10 ms; position(side) every 10 ms; OUTPUT
}
study lifts { vary lift = [1 mm, 2 mm]; measure pull = max(force(roof)); STUDY }
"""


class Silence(NamedTuple):
    """Something more in the scene.

    Attributes:
        place: Where it is written: a word in capitals, or "" for the end.
        text: What is written there.
        code: Of the answer.
        said: A part of its message, or of its hint.
        mended: What is written there by following the hint.
    """

    place: str
    text: str
    code: str
    said: str
    mended: str = ""


S = Silence
#: Sentences that have no effect.
IDLE = {
    "hold of what is fixed": S(
        "SCRIPT", "at 0 s: hold base", "W417", "base is fixed, so holding it has no effect"
    ),
    "hold after a fix": S(
        "SCRIPT", "at 10 ms: hold rim", "W417", "remove one of both",
        "at 10 ms: { free rim; hold rim }",
    ),
    "fixed twice": S("SCRIPT", "at 10 ms: fix base", "W417", "base is fixed already"),
    "seed of a grid": S(
        "STUDY", "seed = 3", "TIS306", "the design grid draws no random numbers",
        "seed = 3; design is latin hypercube; runs = 4",
    ),
}  # fmt: skip
#: Measures of something else than is meant.
MEASURED = {
    "force of a free set": S(
        "OUTPUT", "force(side) every 10 ms", "W703", "weight and inertia of its nodes alone",
        "force(base) every 10 ms",
    ),
    "torque of a free set": S(
        "OUTPUT", "torque(tip) every 10 ms", "W703", "nothing holds, pushes, joins or touches",
        "torque(rim) every 10 ms",
    ),
    "force of a free set in a study": S(
        "STUDY", "measure push = max(force(side))", "W703", "weight and inertia",
        "measure push = max(force(base))",
    ),
    "length of a solid": S(
        "OUTPUT", "length(block) every 10 ms", "TIS702", "name nodes along one edge",
        "length(side) every 10 ms",
    ),
    "length of a wall": S(
        "OUTPUT", "length(flap) every 10 ms", "TIS702", "the distance(A, B) of two sets",
        "distance(rim, tip) every 10 ms",
    ),
    "gap of what is whole": S(
        "OUTPUT", "gap(block) every 10 ms", "W703", "block is in one piece",
        "distance(base, roof) every 10 ms",
    ),
    "gap of what is whole in a study": S(
        "STUDY", "measure wound = max(gap(flap))", "W703", "flap is in one piece",
        "measure wound = max(distance(rim, tip))",
    ),
    "ruptures in a study": S(
        "STUDY", "measure torn = max(ruptured(block))", "W404", "nothing in block can rupture"
    ),
    "time of a rupture": S(
        "STUDY", "measure tear = time of rupture", "W404", "this time never comes"
    ),
}  # fmt: skip
#: Units that are forgotten.
UNITS = {
    "few degrees": S(
        "THREAD", "turned by 5 around (0, 1, 0) through (0, 0, 60) mm", "W504", "write 5 deg",
        "turned by 5 deg around (0, 1, 0) through (0, 0, 60) mm",
    ),
    "few degrees of a motion": S(
        "SCRIPT", "from 60 ms to 90 ms: turn tip by 4 around (1, 0, 0) using smooth profile",
        "W504", "write 4 deg",
        "from 60 ms to 90 ms: turn tip by 4 deg around (1, 0, 0) using smooth profile",
    ),
}  # fmt: skip
SILENCES = {**IDLE, **MEASURED, **UNITS}
