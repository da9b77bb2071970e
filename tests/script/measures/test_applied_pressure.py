"""The applied pressure is that of the script: sums, profiles, solids and sets."""

import numpy as np
import pytest

import tissuec

SCENE = """language 1
tissue gel { Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 5 ms }
body block { mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 10) mm }; tissue is gel }
set top = nodes of block where z == 10 mm
set base = nodes of block where z == 0 mm
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix base
  from 0 s to 4 ms: press top with 100 Pa using ramp
  from 2 ms to 4 ms: press top with -30 Pa
  at 1 ms: press block with 20 Pa
  at 3 ms: stop pressing block
}
simulate { duration = 6 ms; tolerance = 1e-3 }
output { applied pressure(top) every 0.5 ms; applied pressure(block) every 0.5 ms; pressure(block) every 0.5 ms }
expect applied pressure(base) == 0 Pa over run
"""  # noqa: E501


def test_pressures_follow_the_script_and_add_up():
    run = tissuec.run(SCENE, companion="off")
    assert run.manifest["kind"] == "done"
    time = np.linspace(0.0, 6e-3, 13)
    # At times of the script, the log has the value after the event.
    on = (time >= 2e-3 - 1e-9) & (time < 4e-3 - 1e-9)
    top = np.where(time < 4e-3 - 1e-9, 100.0 * time / 4e-3, 0.0) - 30.0 * on
    block = 20.0 * ((time >= 1e-3 - 1e-9) & (time < 3e-3 - 1e-9))
    for name, wanted in (("top", top), ("block", block)):
        log = run.logs[f"applied pressure of {name}"]
        # Profiles are computed to rounding.
        assert log.value[:, 0] == pytest.approx(wanted, abs=1e-9)
    # What the tissue feels is not what is applied.
    assert run.logs["pressure of block"].value[-1, 0] != 0.0
