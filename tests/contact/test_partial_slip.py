"""A pressed ball that is moved sideways: its contact slips from its edge inwards."""

import numpy as np
from scipy.optimize import minimize_scalar

import tissuec

FRICTION, RADIUS, DEPTH = 0.3, 6.0, 1.5  # the last two in mm
SCENE = """language 1
tissue gel {
  Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 1 ms
}
body block {
  mesh is lattice { cell = 2 mm; box from (-16, 0, 0) mm to (16, 16, 12) mm }; tissue is gel
}
set base = nodes of block where z == 0 mm
tool ball { kind is probe; radius = 6 mm; centre = (0, 0, 18) mm }
environment {
  gravity = (0, 0, 0) m/s^2; contact is tools only; friction = 0.3
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
}
script {
  at 0 s: fix base
  from 0 s to 40 ms: move ball by (0, 0, -1.5) mm using smooth profile
  from 60 ms to 160 ms: move ball by (0.75, 0, 0) mm using constant speed
}
simulate { duration = 160 ms; tolerance = 1e-4 }
output { force of ball every 4 ms }
"""


def test_the_force_grows_as_cattaneo_and_mindlin_say_until_all_slips():
    """Compare with μN (1 - (1 - d/s)^(3/2)).

    (C. Cattaneo, Rend. Accad. Lincei 27:342, 1938; R. D. Mindlin, J. Appl. Mech. 16:259, 1949.)
    """
    with tissuec.run(SCENE, companion="off") as run:
        assert run.finished
        log = run.logs["force of ball"]
        time, force = log.time, -2e3 * log.value  # [mN], of both halves
    moves = time > 62e-3
    way = 7.5 * (time[moves] - 60e-3)  # [mm]
    along, normal = -force[moves, 0], force[moves, 2]
    share = along / (FRICTION * normal)
    slips = way > 0.65
    # The ball pushes a dent ahead of it, so that pressures lean.
    assert share[slips].min() > 1.0 and share[slips].max() < 1.04

    def expected(all_slips):
        return 1.0 - np.maximum(1.0 - way / all_slips, 0.0) ** 1.5

    def error(all_slips):
        return np.abs(share - expected(all_slips))[~slips].max()

    found = minimize_scalar(error, bounds=(0.3, 1.2), method="bounded")
    assert found.fun < 0.03
    # Sideways, the block is stiffer than a half space, but by less than when pressed.
    contact, shear = np.sqrt(RADIUS * DEPTH), 10.0 / 2.6
    stiffness = 1.5 * FRICTION * normal[0] / found.x
    half_space = 8.0 * contact * shear / (2.0 - 0.3)
    hertz = 4.0 / 3.0 * 10.0 / 0.91 * np.sqrt(RADIUS * DEPTH**3)
    assert 1.0 < stiffness / half_space < normal[0] / hertz
