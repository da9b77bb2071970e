# ruff: noqa: E501  # texts as they are
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
  tissue is hard; thickness = 1 mm
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
        mended: What is written there by following the hint; nothing to remove it.
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
    "motion by 0": S(
        "SCRIPT", "from 60 ms to 90 ms: move tip by (0, 0, 0) mm using smooth profile",
        "W417", "the vector of the motion is 0, so this moves nothing",
        "from 60 ms to 90 ms: move tip by (0, 0, 1) mm using smooth profile",
    ),
    "turn by 0": S(
        "SCRIPT", "from 60 ms to 90 ms: turn tip by 0 deg around (1, 0, 0) using ramp",
        "W417", "the angle is 0, so this moves nothing",
        "from 60 ms to 90 ms: turn tip by 90 deg around (1, 0, 0) using ramp",
    ),
    "push with 0 N": S(
        "SCRIPT", "at 60 ms: push tip with 0 N along (0, 0, 1)", "W417", "for example: with 0.1 N",
        "at 60 ms: push tip with 0.1 N along (0, 0, 1)",
    ),
    "pull with 0 N": S(
        "SCRIPT", "at 60 ms: pull tip with (0, 0, 1 N - 1 N)", "W417", "the force is 0",
        "at 60 ms: pull tip with 0.1 N along (0, 0, 1)",
    ),
    "press with 0 Pa": S(
        "SCRIPT", "at 60 ms: press flap with 0 Pa along (0, 0, 1)", "W417", "the pressure is 0",
        "at 60 ms: press flap with 16 kPa along (0, 0, 1)",
    ),
    "tissue of nothing": S(
        "", "tissue spare like gel { density = 1.1 g/cm^3 }", "W502", "make a body or a joint of it",
        "tissue spare like gel { density = 1.1 g/cm^3 }\n"
        "body more like block { tissue is spare; moved by (0, 0, 90) mm }",
    ),
    "tool without a shape": S("", "tool shears { kind is scissors }", "W502", "name it in the script"),
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
    "speed of a fixed set": S(
        "OUTPUT", "speed(base) every 10 ms", "W703", "base is fixed at 0 s and never freed",
        "speed(side) every 10 ms",
    ),
    "speed of a fixed set in a study": S(
        "STUDY", "measure pace = max(speed(rim))", "W703", "name nodes that can move",
        "measure pace = max(speed(tip))",
    ),
    "kinetic energy of a fixed set": S(
        "OUTPUT", "kinetic energy(rim) every 10 ms", "W703", "rim is fixed at 0 s",
        "kinetic energy(flap) every 10 ms",
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
_BODY = "body more like block { tissue is own; moved by (0, 0, 90) mm }"


def _own(written: str) -> str:
    return f"tissue own like gel {{ {written} }}\n{_BODY}"


#: The same kinds, by fewer words: the code of the answer, and a part of it.
MORE = {
    "release of what is fixed": S("SCRIPT", "at 60 ms: release base", "TIS401", 'write "free base"'),
    "viscosity of elements changed": S(
        "SCRIPT", "at 20 ms: change viscosity of block to 1 N*s/m", "TIS309", "changes nothing"),
    "friction without contact": S("ENVIRONMENT", "friction = 0.3", "TIS306", "contact is tools only"),
    "thickness without contact": S("ENVIRONMENT", "contact thickness = 1 mm", "TIS306", "no effect"),
    "stiffness without contact": S("ENVIRONMENT", "contact stiffness = 1 kN/m", "TIS306", "no effect"),
    "rupture without a limit": S("BLOCK", "rupture is allowed", "TIS206", "breaking strain"),
    "output later than the end": S("OUTPUT", "torque(rim) every 1 s", "W405", "shorter time"),
    "cut beside a thread": S(
        "SCRIPT", "at 20 ms: cut suture along plane through (50, 0, 0) mm facing (1, 0, 0)",
        "W410", "cut where it is"),
    "action after the end": S("SCRIPT", "at 2 s: fix tip", "W402", "ends at"),
    "tool without contact": S(
        "", "tool ball { kind is probe; centre = (5, 0, 90) mm; radius = 5 mm }", "W407", "contact is"),
    "unused number": S("", "param spare = 1 mm", "W501", "never used"),
    "unused set": S("", "set spare = nodes of block where x == 0 mm", "W502", "never used"),
    "fixed set is moved": S(
        "SCRIPT", "from 60 ms to 90 ms: move base by (0, 0, 1) mm using smooth profile", "W409", ""),
    "fixed set is pushed": S(
        "SCRIPT", "from 60 ms to 90 ms: push base with (0, 0, 1) mN using ramp", "W417", "is fixed"),
    "interval of a fix": S("SCRIPT", "from 60 ms to 90 ms: fix tip", "W412", ""),
    "friction of a tissue without contact": S("", _own("friction = 0.3"), "W407", "contact is off"),
    "breaking strain without rupture": S("", _own("breaking strain = 30 %"), "W404", "rupture is allowed"),
    "stress of a thread": S("OUTPUT", "stress(suture) every 10 ms", "TIS702", "block, flap"),
    "tension of a solid": S("OUTPUT", "tension(block) every 10 ms", "TIS702", "suture"),
    "volume of a flat wall": S("OUTPUT", "volume(flap) every 10 ms", "TIS702", "encloses"),
    "pressure of a wall": S("OUTPUT", "pressure(flap) every 10 ms", "W703", "nothing presses flap"),
    "grip of a set": S("OUTPUT", "grip(roof) every 10 ms", "TIS702", "forceps with jaws"),
    "penetration without contact": S("OUTPUT", "penetration(block) every 10 ms", "TIS702", "contact is off"),
    "contact area without contact": S("OUTPUT", "contact area(block) every 10 ms", "TIS702", "contact is off"),
    "elastic energy of a row of nodes": S("OUTPUT", "elastic energy(rim) every 10 ms", "W703", "a body"),
    "plastic strain of gel": S("OUTPUT", "plastic strain(block) every 10 ms", "W703", "yield stress"),
    "ruptures of a thread": S("OUTPUT", "ruptured(suture) every 10 ms", "W404", "always 0"),
    "applied pressure without any": S("OUTPUT", "applied pressure(roof) every 10 ms", "W703", "presses"),
    "force of a whole wall": S("OUTPUT", "force(flap) every 10 ms", "W703", "that is held"),
    "distance from itself": S("OUTPUT", "distance(rim, rim) every 10 ms", "TIS702", "both are rim"),
    "magnitude that is not negative": S(
        "", "expect force(roof) >= 0 N over run", "W701", "write a direction"),
    "damping without a unit": S("ENVIRONMENT", "damping = 5", "TIS501", '"5 N*s/m"'),
    "density in g/cm^3": S("", _own("density = 1 kg/m^3"), "W504", "did you mean 1 g/cm^3"),
    "Poisson's ratio in per cent": S("", _own("Poisson's ratio = 45"), "TIS308", "0.4999"),
    "thickness in m": S("", "body more like flap { thickness = 1 m; moved by (0, 0, 90) mm }", "W504", "1 mm"),
    "motion in m": S(
        "SCRIPT", "from 60 ms to 90 ms: move tip by (0, 0, 1) m using smooth profile", "W504", "units"),
    "sine of degrees": S("BLOCK", "velocity = (0, 0, sin(30)) m/s", "W504", "30 deg"),
    "box in m": S(
        "", "body more { mesh is lattice { cell = 5 m; box from (0, 0, 90) m to (20, 10, 100) m }; "
        "tissue is gel }", "W504", "20 cm"),
    "region beside the mesh": S("BLOCK", "region part where x > 30 mm { tissue is hard }", "TIS302", "20 mm"),
    "region within a cell": S(
        "BLOCK", "region part where within 1 mm of (12, 5, 5) mm { tissue is hard }", "TIS302", "no node"),
    "plane of symmetry beside the mesh": S(
        "ENVIRONMENT", "symmetric about plane through (50, 0, 0) mm facing (1, 0, 0)", "TIS309", "nearest"),
    "plane of symmetry through a body": S(
        "ENVIRONMENT", "symmetric about plane through (10, 0, 0) mm facing (1, 0, 0)", "TIS309", "one side"),
    "joint out of reach": S(
        "", "joint glue { springs from roof to tip; reach = 1 mm; tissue is silk }", "TIS302", "30 mm apart"),
}  # fmt: skip
#: What is right, although it resembles the above: where it is written, and the text.
RIGHT = {
    "motion by a param that is 0": (
        "SCRIPT", "from 60 ms to 90 ms: move tip by (0, 0, 0 * lift) using smooth profile"),
    "repetition that begins with 0": (
        "SCRIPT", "repeat i from 0 to 1 { at 60 ms: push tip with i * (0, 0, 1) mN }"),
    "push that is 0 in one direction": ("SCRIPT", "at 60 ms: push tip with (0, 0, 1) mN"),
    "base of a tissue": (
        "", f"tissue first like gel {{ density = 1.1 g/cm^3 }}\ntissue own like first {{ }}\n{_BODY}"),
    "tissue of a library": ("", 'use "matter/liver"'),
    "tool that is measured": (
        "", "tool clip { kind is clamp }\nexpect speed(clip) < 1 m/s over run"),
    "friction of no amount": ("", _own("friction = 0")),
    "speed of a set that is freed": (
        "SCRIPT", "at 60 ms: free rim\n}\nstudy more { vary lift = [1 mm, 2 mm]; measure pace = max(speed(rim))"),
}  # fmt: skip
