"""Every method with every force, on scenes in which the force begins during the run, and SciPy.

A method may carry a force that acts from 0 s on and lose one that begins later.
"""

import warnings
from functools import cache

import numpy as np
import pytest

import tissuec
from tests.contact.scenes import play
from tests.engine.members import MEMBERS
from tests.every import every
from tests.validate.scenes import compiled_scene
from tissuec.engine.execution.recorder import sample_times
from tissuec.engine.run_arrays import FLOOR
from tissuec.validate.reference import reference

TOLERANCE = 1e-4
HEAD = """language 1
tissue cord { spring constant = 40 N/m; viscosity = 20 mN*s/m; mass = 2 g; MORE }
"""
ROD = """body rod { mesh is explicit; tissue is cord; BODY }
table nodes of rod in mm with columns "id x y z" { 1 0 0 0; 2 10 0 0; 3 20 0 0; 4 20 10 0 }
table springs of rod in mm with columns "a b" { 1 2; 2 3; 3 4; 1 3; 2 4 }
set wall = nodes of rod in [1]
set tip = nodes of rod in [3, 4]
set bar = springs of rod in [5]
"""
TAIL = """environment { gravity = (0, 0, 0) m/s^2; ENVIRONMENT }
script { at 0 s: fix wall; SCRIPT }
simulate { integrator is METHOD; duration = 60 ms; tolerance = 1e-4 }
output { trajectory every 5 ms }
"""
FALLING = """body rod { mesh is explicit; tissue is cord; velocity = (0.3, 0, -0.4) m/s }
table nodes of rod in mm with columns "id x y z" { 1 0 0 5; 2 10 0 5; 3 0 10 5; 4 3 3 13 }
table springs of rod in mm with columns "a b" { 1 2; 1 3; 1 4; 2 3; 2 4; 3 4 }
"""
PLANE = "tool bed { kind is plane; point = (0, 0, 0) mm; normal = (0, 0, 1) }\n"
KNOB = (
    "tool knob { kind is probe; radius = 4 mm; axis from (-9, 3, -5) mm to (29, 3, -5) mm }\n"
)
LANDING = "gravity = (0, 0, -9.81) m/s^2; contact is tools only; contact layer = 1 mm"
PULL = "from 20 ms to 40 ms: push tip with (0.05, 0.1, 0.02) N using smooth profile"
BALL = """body ball {
  mesh is sphere { centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 0 }
  tissue is cord }
set wall = nodes of ball where z < -8 mm
"""
SHEET = """tissue skin { spring constant = 14 N/m; density = 1000 kg/m^3
  retardation time = 1 ms }
body sheet { mesh is sheet { corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm
  second edge = (0, 10, 0) mm; rows = 2; columns = 3; diagonals is both }
  tissue is skin; thickness = 1 mm; BODY }
set wall = nodes of sheet where x < 1 mm
set tip = nodes of sheet where x > 19 mm
"""
BED = """force bed { kind is foundation; acts on sheet; stiffness = 20 kPa/m
  damping = 4 Pa*s/m }
"""
NOZZLE = """tool nozzle { kind is nozzle; diameter = 2 mm; tip = (14, 5, 15) mm
  direction = (0, 0, -1) }
"""
LEDGE = """tissue rock { spring constant = 35 N/m; density = 2000 kg/m^3
  retardation time = 1 ms }
body ledge {
  mesh is sheet { corner = (-8, -8, 0) mm; first edge = (30, 0, 0) mm
  second edge = (0, 30, 0) mm; rows = 2; columns = 2; diagonals is both }
  tissue is rock; thickness = 1 mm }
set wall = nodes of ledge where x < 99 mm
"""
JOINED = """body rod { mesh is explicit; tissue is cord }
body other { mesh is explicit; tissue is cord }
table nodes of rod in mm with columns "id x" { 1 0 }
table nodes of other in mm with columns "id x vx in mm/s" { 1 10 0 }
set wall = nodes of rod in [1]
joint link { springs from rod to other; tissue is cord }
"""
#: What begins, with its bodies, environment, script and further entries of tissue and body.
SCENES = {
    "push": (ROD, "", PULL, "", ""),
    "motion": (
        ROD, "", "from 20 ms to 40 ms: move tip by (3, 1, 0) mm using smooth profile", "", "",
    ),
    "gravity": (ROD, "", "at 20 ms: change gravity to (1, 2, -9) m/s^2", "", ""),
    "drag": (ROD, "", f"{PULL}; at 30 ms: change damping to 0.1 N*s/m", "", ""),
    "cut": (ROD, "", f"{PULL}; at 30 ms: cut bar", "", ""),
    "rupture": (ROD, "", PULL, "breaking force = 0.03 N", "rupture is allowed"),
    "tension only": (ROD, "", PULL, "spring law is tension only", ""),
    "contact": (FALLING + PLANE, LANDING, "", "", ""),
    "contact damping": (FALLING + PLANE, LANDING + "; contact damping = 2 s/m", "", "", ""),
    "friction": (FALLING + PLANE, LANDING + "; friction = 0.4", "", "", ""),
    "round tool": (FALLING + KNOB, LANDING + "; friction = 0.4", "", "", ""),
    "bodies": (FALLING + LEDGE, LANDING.replace("tools only", "bodies too")
               + "; friction = 0.4; contact thickness = 1 mm", "", "", ""),
    "foundation": (SHEET + BED, "", PULL.replace("0.05, 0.1, 0.02", "0, 0, 1e-3"), "", ""),
    "jet": (
        SHEET + NOZZLE, "",
        "from 20 ms to 60 ms: irrigate sheet with 2 ml/s through nozzle", "", "",
    ),
    "joint": (
        JOINED, "", "from 20 ms to 40 ms: tighten link to 8 mm using smooth profile", "", "",
    ),
    "pressure": (
        BALL, "", "at 20 ms: preserve volume of ball with 20 kPa; "
        "from 25 ms to 50 ms: inflate ball to 3 ml using smooth profile", "", "",
    ),
    "bending": (SHEET, "", PULL.replace("0.05, 0.1, 0.02", "0, 0, 1e-3"), "", ""),
    "relaxing": (ROD, "", PULL, "relaxing constant = 30 N/m; relaxation time = 10 ms", ""),
    "yielding": (ROD, "", PULL, "yield force = 0.02 N; yield viscosity = 1 N*s/m", ""),
}  # fmt: skip


def scene(force, method):
    """Return the text in which a force begins, for a method."""
    bodies, environment, script, tissue, body = SCENES[force]
    fix = "" if "set wall" in bodies else "at 0 s: fix wall; "
    text = HEAD + bodies + TAIL.replace(fix or "NOTHING", "")
    parts = {"MORE": tissue, "BODY": body, "ENVIRONMENT": environment, "SCRIPT": script}
    for name, value in (parts | {"METHOD": method}).items():
        text = text.replace(name, value)
    return text if not environment else text.replace("gravity = (0, 0, 0) m/s^2; ", "")


@cache
def exact(force):
    """Return the positions of SciPy in the frames [m], shape (frame, node, 3)."""
    compiled = compiled_scene(scene(force, "dop853"))
    network, plan = compiled.network, compiled.plan
    found = reference(network, plan, sample_times(plan), method="DOP853", rtol=1e-6)
    return found.position[:, : network.body_nodes]


def error(force, method):
    """Return the largest error so far over the largest displacement so far."""
    known, played = exact(force), play(scene(force, method))
    assert played.outcome.kind == "done"
    found = played.position[:, : known.shape[1]]
    moved = np.maximum.accumulate(np.linalg.norm(known - known[0], axis=2).max(axis=1))
    off = np.linalg.norm(found - known, axis=2).max(axis=1)
    floor = FLOOR * played.compiled.network.extent
    return float((off / np.maximum(moved, floor)).max())


def check(force, method):
    assert error(force, method) < TOLERANCE or is_told(force, method)


def is_told(force, method):
    """Return whether the run says itself that it is less accurate."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return tissuec.run(scene(force, method), companion="inline").promise.since is not None


#: What "contact damping", "round tool" and ``contact/test_friction`` have as well.
HAD_BY_OTHERS = {"contact", "friction"}


@every(("force", "method"), [(f, "esdirk43") for f in SCENES if f not in HAD_BY_OTHERS])
def test_a_force_that_begins_is_felt_by_an_implicit_method(force, method):
    check(force, method)


@pytest.mark.slow
@every(("force", "method"), [(f, m) for f in SCENES for m in ("automatic", *MEMBERS)])
def test_a_force_that_begins_is_felt_by_every_method(force, method):
    check(force, method)
