"""Modes of solid elements beside those of an independent library of finite elements."""

import numpy as np

import tissuec

SCENE = """language 1
tissue gel {{ Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }}
body bar {{
  mesh is lattice {{ cell = {cell} mm; box from (0, 0, 0) mm to (60, 10, 10) mm }}
  tissue is gel
}}
set root = nodes of bar where x < 0.1 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: fix root }}
simulate {{ duration = 1 s }}
"""
#: [Hz], of two bendings, a torsion and a bending, by hexahedra of 27 nodes of felupe 11.3 with
#: their consistent mass; the last digit has converged.
KNOWN = np.array([1.3997, 1.3997, 7.530, 7.853])


def test_a_clamped_bar_swings_as_finite_elements_of_another_library_do():
    found = np.array(
        [
            [one.frequency for one in tissuec.modes(SCENE.format(cell=cell), count=4)]
            for cell in (5, 2.5)
        ]
    )
    coarse, fine = np.abs(found / KNOWN - 1.0)
    assert fine[[0, 1, 3]].max() < 0.005
    assert coarse[[0, 1, 3]].max() < 0.02
    # Masses have the moment of inertia of the bar, whose torsion is too stiff.
    assert fine[2] < 0.02
