"""A tissue that is learnt as matter on one mesh predicts another one."""

import numpy as np

from tests.matter.elastic import drawn_out
from tissuec.learn.fit.learning import learn
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

COUPON = """language 1
tissue gel {{ Young's modulus = {young} kPa; density = 1000 kg/m^3; retardation time = 5 ms }}
body piece {{
  made of springs
  mesh is lattice {{
    kind is sodium chloride; reach is second neighbours
    cell = {cell} mm; box from (0, 0, 0) mm to (40, 10, 10) mm
  }}
  tissue is gel
}}
set left = nodes of piece where x < 0.1 mm
set right = nodes of piece where x > 39.9 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{
  at 0 s: fix left
  from 0 s to 1 s: move right by (0.2, 0, 0) mm using constant speed
}}
simulate {{ duration = 1 s }}
learn gel {{
  data = "pull.csv"
  displacement of right using column "u_mm" in mm
  fit = force(right along (1, 0, 0)) using column "force_mN" in mN
  adjust Young's modulus of gel
}}
"""


def test_what_a_coarse_coupon_taught_holds_for_a_fine_one(tmp_path):
    (tmp_path / "pull.csv").write_text("u_mm,force_mN\n0.1,1\n0.2,2\n")

    def compiled(young, cell):
        path = tmp_path / f"cells_{cell}.tis"
        path.write_text(COUPON.format(young=young, cell=cell))
        request = Request.file(path)
        return compile_request(request)[0], request

    fine, _ = compiled(8.0, 5)
    force, _ = drawn_out(fine.network, fine.plan, 0, held_across=True)
    u = np.linspace(0.04, 0.2, 5)
    noise = 0.01 * np.random.default_rng(3).standard_normal(len(u))
    rows = np.stack([u, 1e3 * force * u / 40.0 * (1.0 + noise)], axis=1)
    np.savetxt(tmp_path / "pull.csv", rows, delimiter=",", header="u_mm,force_mN", comments="")
    coarse, request = compiled(5.0, 10)
    found = learn(coarse, coarse.fit_problems[0], request)
    (estimates,) = found.estimates
    (young,), (low,), (high,) = estimates.value, estimates.low, estimates.high
    # The interval knows of the noise alone; meshes of 1 and 2 cells differ by about 1 %
    # when held across.
    assert low < high < low * 1.05
    assert 0.985 * low < 8e3 < 1.015 * high
    learnt, _ = compiled(young / 1e3, 5)
    again, _ = drawn_out(learnt.network, learnt.plan, 0, held_across=True)
    assert 0.985 * low / young < force / again < 1.015 * high / young
