"""Stepping gives the motion of a run where a probe touches, springs tear and triggers fire."""

import pytest

import tissuec
from tests.stepping.test_stepped_run import assert_same

#: A probe goes through a held sheet that relaxes, and is drawn back once the sheet has torn.
PIERCED = """language 1
tissue skin {
  spring constant = 20 N/m; viscosity = 5 mN*s/m; mass = 10 mg; breaking force = 40 mN
  relaxing constant = 5 N/m; relaxation time = 20 ms
}
body sheet {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 20, 0) mm
    columns = 5; rows = 5; diagonals is both
  }
  tissue is skin
  rupture is allowed
}
set tip = nodes of sheet where within 2 mm of (10, 10, 0) mm
set rim = nodes of sheet where x < 1 mm or x > 19 mm or y < 1 mm or y > 19 mm
tool tongs { kind is forceps }
tool finger { kind is probe; radius = 3 mm; centre = (10, 10, 4) mm }
environment {
  gravity = (0, 0, 0) m/s^2; damping = 0.1 mN*s/m
  contact is tools only; contact stiffness = 200 N/m; friction = 0.3
}
script {
  at 0 s: fix rim
  from 0 s to 80 ms: move finger by (1, 0, -12) mm using smooth profile
  when force(finger) > 30 mN: change viscosity of sheet by 2
  when ruptured(sheet): {
    after 10 ms: push tip with (0, 0, 2) mN on each node
  }
}
simulate { duration = 0.1 s; METHOD }
output {
  trajectory every 10 ms; position of tip every 1 ms; force of finger every 1 ms
  energy every 5 ms
}
"""


@pytest.mark.parametrize(
    "method",
    [
        "tolerance = 1e-3",
        pytest.param("step = 0.1 ms; integrator is velocity verlet", marks=pytest.mark.slow),
    ],
)
def test_a_probe_that_tears_a_sheet(method):
    sim = tissuec.start(PIERCED.replace("METHOD", method))
    saved, steps = None, 0
    while not sim.ended:
        sim.step("1.3 ms")
        steps += 1
        if steps == 30:
            saved = sim.save()
            sim.push("tip", with_=(1e-3, 0, 0), over="5 ms")
        if steps % 10 == 0:
            sim = sim.fork()
    assert_same(sim, sim.script())
    assert {"rupture", "trigger"} <= {event.kind for event in sim.events}
    assert -sim.log("force of finger")[1].min() > 0.03  # it touches
    sim.restore(saved)
    sim.run_until("0.1 s")
    assert_same(sim, PIERCED.replace("METHOD", method))
