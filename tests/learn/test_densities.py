"""Masses follow from the densities of all parts of a solid, with exact derivatives."""

import numpy as np
import pytest

from tissuec.learn.parameters.parametrisation import Parametrisation
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

SCENE = """language 1
tissue gum {{ Young's modulus = 40 kPa; density = 1000 kg/m^3 }}
tissue bone {{ Young's modulus = 40 kPa; density = 2000 kg/m^3 }}
body cube {{ mesh is lattice {{ cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }}
  tissue is gum; {region} }}
set foot = nodes of cube where x < 1 mm
set tip = nodes of cube where x > 19 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: fix foot; from 0 s to 10 ms: move tip by (1, 0, 0) mm using smooth profile }}
simulate {{ duration = 10 ms }}
learn gum {{ data = "data.csv"; fit = force(tip along (1, 0, 0)) using column "f_N" in N
  {adjust} }}
"""
CORE = "region core where x > 10 mm { tissue is bone }"


@pytest.mark.parametrize(
    ("region", "tissues"), [(CORE, ("gum", "bone")), (CORE, ("bone",)), ("", ("gum",))]
)
def test_masses_follow_from_densities(region, tissues, tmp_path):
    (tmp_path / "data.csv").write_text("t_s,f_N\n0,0\n0.01,1\n", encoding="utf-8")
    adjust = "; ".join(f"adjust density of {name}" for name in tissues)
    path = tmp_path / "scene.tis"
    path.write_text(SCENE.format(region=region, adjust=adjust), encoding="utf-8")
    compiled = compile_request(Request.file(path))[0]
    (problem,) = compiled.fit_problems
    shaping = Parametrisation(compiled, problem)
    theta = np.linspace(0.3, -0.4, shaping.size)
    order = shaping.order
    mass = order.array(shaping.vector(theta), "mass")
    np.testing.assert_allclose(mass, shaping.network(theta).mass, rtol=1e-9)
    found = shaping.change(theta)[order.places["mass"]].toarray()
    step = 1e-4
    for k, ahead in enumerate(step * np.eye(shaping.size)):
        due = shaping.network(theta + ahead).mass - shaping.network(theta - ahead).mass
        # A second difference of this step is 1e-8 of the first, differences are rounding.
        np.testing.assert_allclose(
            found[:, k], due / (2.0 * step), rtol=0, atol=1e-7 * mass.max()
        )


def test_where_weights_change_otherwise_finite_differences_are_taken(tmp_path):
    (tmp_path / "data.csv").write_text("t_s,f_N\n0,0\n0.01,1\n", encoding="utf-8")
    path = tmp_path / "scene.tis"
    for region, name in ((CORE, "density of gum"), ("", "")):
        text = SCENE.format(region=region, adjust="adjust density of gum")
        path.write_text(text.replace("(0, 0, 0) m/s^2", "(0, 0, -10) m/s^2"), encoding="utf-8")
        compiled = compile_request(Request.file(path))[0]
        assert Parametrisation(compiled, compiled.fit_problems[0]).refusal == name
