"""Scenes of studies that tests share: a spring that is stretched, with its study."""

from pathlib import Path

from tissuec.core.source import Source
from tissuec.core.workers.workers import OwnProcess
from tissuec.scene.request import Request
from tissuec.studies.study import PreparedStudy, StudyResult, prepare, run_study

#: The words of a tissue.
WORDS = """described in soft tissue
  hardness is soft
  elasticity is medium
  weight is medium
  shiftability is medium
  consistency is smooth"""
#: A node on a spring of 2 N/m is moved by "lift" within 0.1 s; it breaks beyond 12 mN.
SCENE = """language 1
use "fuzzy/soft_tissue"
param lift = 2 mm between 0 mm and 20 mm
tissue spring {
  WORDS
  spring constant = 2 N/m
  viscosity = 1 mN*s/m
  fraction force = 12 mN
}
tissue stiff spring like spring { spring constant = 4 N/m }
body bar { mesh is explicit; tissue is spring; rupture is allowed }
table nodes of bar in mm with columns "id x mass in g" { 1 0 1; 2 10 1; 3 20 1 }
table springs of bar with columns "a b" { 1 2; 2 3 }
tool hand { kind is forceps }
set foot = nodes of bar where id == 1
set middle = nodes of bar where id == 2
set tip = nodes of bar where id == 3
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix foot
  at 0 s: grasp tip with hand
  from 0 s to 0.1 s: move hand by (lift, 0, 0) using ramp
}
simulate { duration = 0.2 s; tolerance = 1e-4 }
output { trajectory every 10 ms; force of hand every 1 ms }
""".replace("WORDS", WORDS)
#: A mass between springs without losses, which all integrators can step.
CHAIN = """language 1
tissue spring { spring constant = 2 N/m; viscosity = 0 N*s/m }
body chain { mesh is explicit; tissue is spring }
table nodes of chain in mm with columns "id x mass in g" { 1 0 4; 2 12 4; 3 20 4; 4 30 4 }
table springs of chain with columns "a b rest length in mm" { 1 2 10; 2 3 10; 3 4 10 }
set walls = nodes of chain where id == 1 or id == 4
set middle = nodes of chain where id == 2
environment { gravity = (0, 0, 0) m/s^2; contact is off; damping = 0 N*s/m }
script { at 0 s: fix walls }
simulate { duration = 0.2 s; step = 1 ms; integrator is dop853 }
"""
STUDY = """study pulling {
  vary lift = 2 mm to 6 mm in 3 steps
  vary tissue of bar = [spring, stiff spring]
  measure pull = max(force of hand)
  measure place = position of middle along (1, 0, 0) at 0.15 s
  measure tear = time of rupture
  measure curve = force of hand every 50 ms
}
"""


def request(text: str = SCENE + STUDY, folder: Path | None = None) -> Request:
    """Return the request of a text, as a file of a folder if there is one."""
    path = None if folder is None else folder / "bar.tis"
    if path is not None:
        path.write_text(text, "utf-8")
    return Request(Source("bar.tis", text, path))


def prepared(*sentences: str, text: str = SCENE + STUDY, **more) -> PreparedStudy:
    """Return a study that can begin, with more sentences."""
    return prepare(request(text), sentences=sentences, **more)


def carried_out(*sentences: str, text: str = SCENE + STUDY, **more) -> StudyResult:
    """Return what a study in this process comes to."""
    return run_study(prepared(*sentences, text=text), OwnProcess(), **more)
