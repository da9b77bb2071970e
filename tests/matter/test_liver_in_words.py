"""A block of liver that is described in words alone bears what was measured."""

import tissuec

#: 80 mm long, of 40 mm x 20 mm, held and drawn by its ends.
SCENE = """language 1
use "fuzzy/soft_matter"
tissue parenchyma {
  described in soft matter
  hardness is soft; elasticity is small; weight is medium; shiftability is medium
  consistency is smooth; extensibility is medium; cohesion is friable
  tightening is slightly sudden
}
body block {
  mesh is lattice { cell = 10 mm; box from (0, 0, 0) mm to (80, 40, 20) mm }
  tissue is parenchyma
  rupture is allowed
}
set root = nodes of block where x < 0.1 mm
set edge = nodes of block where x > 79.9 mm
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix root
  from 0 s to 0.6 s: move edge by (48, 0, 0) mm using constant speed
  when ruptured(block) > 0: end the run
}
simulate { duration = 0.6 s; integrator is equilibrium; step = 10 ms }
output { force of root every 10 ms }
"""
SECTION = 800e-6  # [m^2]


def test_a_liver_in_words_is_as_stiff_and_as_strong_as_measured(tmp_path):
    result = tissuec.run(SCENE, out=tmp_path / "liver.vtkhdf", companion="off")
    log = result.logs["force of root"]
    strain, force = log.time, abs(log.value[:, 0])  # 60 % in 0.6 s
    # 437 healthy persons: Hepatology 2012, doi:10.1002/hep.24694. The held ends add a tenth.
    early = (strain > 0.01) & (strain < 0.03)
    modulus = (force[early] / strain[early]).mean() / SECTION
    assert 3.2e3 < modulus < 1.1 * 8.5e3
    # Human parenchyma: Kemper et al. 2010, Stapp Car Crash J 54:15.
    assert 30e3 < force.max() / SECTION < 61e3
    assert 0.24 < strain[-1] < 0.47
