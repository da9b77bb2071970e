"""Walls on solids and threads inside them, by closed forms."""

import pytest

import tissuec

LIVER = """language 1
tissue parenchyma { Young's modulus = 10 kPa; Poisson's ratio = 0; density = 1060 kg/m^3 }
tissue capsule { Young's modulus = 4 MPa; Poisson's ratio = 0; density = 1060 kg/m^3 }
body liver {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (40, 20, 10) mm }
  tissue is parenchyma
}
body cover {
  mesh is sheet {
    corner = (0, 0, 10) mm; first edge = (40, 0, 0) mm; second edge = (0, 20, 0) mm
    columns = @C; rows = @R
  }
  tissue is capsule; thickness = 0.1 mm; made of elements
}
joint bond { glue from cover to liver }
set left = nodes of [liver, cover] where x < 0.1 mm
set right = nodes of [liver, cover] where x > 39.9 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix left; from 0 s to 1 s: move right by (0.04, 0, 0) mm using constant speed }
simulate { duration = 1 s; integrator is equilibrium; step = 0.5 s }
output { force(right) every 0.5 s }
"""


@pytest.mark.parametrize(("columns", "rows"), [(9, 5), (17, 9)])
def test_a_capsule_on_a_solid_carries_its_share(columns, rows):
    """(10 kPa · 200 mm² + 4 MPa · 2 mm²) · 0.1 % = 10 mN, less 0.15 % by the law.

    The wall alone bends the block: of both, the ends are held, and the middle is stiffer.
    """
    text = LIVER.replace("@C", str(columns)).replace("@R", str(rows))
    run = tissuec.run(text, companion="off")
    assert run.logs["force of right"].value[-1, 0] == pytest.approx(10e-3, rel=5e-3)


FIBRE = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0; density = 1000 kg/m^3 }
tissue silk { spring constant = 900 N/m; viscosity = 0 N*s/m; mass = 1 mg }
body block {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (30, 10, 10) mm }; tissue is gel
}
body strand {
  mesh is thread { line from (0, @Y, @Z) mm to (30, @Y, @Z) mm; pieces = @N; thickness = 1 mm }
  tissue is silk
}
@JOINT
set left = nodes of @WHO where x < 0.1 mm
set right = nodes of @WHO where x > 29.9 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix left; from 0 s to 1 s: move right by (0.3, 0, 0) mm using constant speed }
simulate { duration = 1 s; integrator is equilibrium; step = 0.5 s }
output { force(right) every 0.5 s }
"""


def fibre(y=5, z=5, pieces=8, joint="joint bond { glue from strand to block }"):
    who = "[block, strand]" if joint else "block"
    text = FIBRE.replace("@Y", str(y)).replace("@Z", str(z)).replace("@N", str(pieces))
    return text.replace("@JOINT", joint).replace("@WHO", who)


@pytest.mark.parametrize(("y", "z", "pieces"), [(5, 5, 6), (5, 5, 7), (3.3, 6.1, 11)])
def test_a_thread_inside_a_block_carries_its_load(y, z, pieces):
    """900 N/m a piece, in series, are stretched by 0.3 mm beside the block.

    At a strain of 1 %, its square bends the fields near the held ends by less than 1e-7.
    """
    plain, fibred = (
        tissuec.run(text, companion="off").logs["force of right"].value[-1]
        for text in (fibre(joint=""), fibre(y, z, pieces))
    )
    alone = 900 / pieces * 0.3e-3
    assert fibred[0] - plain[0] == pytest.approx(alone, rel=1e-7)
