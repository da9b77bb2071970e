"""W217: how stiff bars of alternately tapering hexahedra are, foretold and measured."""

import numpy as np
import pytest

import tissuec
from tests.imports.organs import grid_of_hexahedra, write_vtk
from tests.validate.scenes import compiled_scene
from tissuec.compiler.checks.tapered_cells import tapered

TEXT = """language 1
tissue gel {{ Young's modulus = 1 MPa; Poisson's ratio = 0; density = 1000 kg/m^3 }}
body bar {{ mesh is imported {{ file "bar.vtk" in mm }}; tissue is gel }}
set near = nodes of bar where x < 0.001 mm
set far = nodes of bar where x > 5.999 mm
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: {{ fix near; push far with (0, 0, {load}) mN; settle }} }}
simulate {{ duration = 2 us; integrator is dop853 }}
output {{ position of far every 1 us }}
"""
LONG, YOUNG = 6.0, 1e3  # [mm], [kPa]


def bar(folder, cells, thick, shift, layers):
    """Write a bar of trapezoids: every other section leans by ``shift`` [mm] to either side."""
    x = np.linspace(0.0, LONG, cells + 1)
    lean = shift * (-1.0) ** np.arange(cells + 1)
    lean[[0, -1]] = 0.0
    z = np.linspace(-0.5, 0.5, layers + 1)
    place = np.zeros((cells + 1, 2, layers + 1, 3))
    place[..., 0] = x[:, None, None] + lean[:, None, None] * 2.0 * z
    place[..., 1] = thick * np.array([0.0, 1.0])[:, None]
    place[..., 2] = thick * z
    write_vtk(folder / "bar.vtk", *grid_of_hexahedra(place))


@pytest.mark.parametrize(
    ("cells", "thick", "shift", "layers"),
    [
        (6, 0.2, 0.1, 1),
        (6, 0.2, 0.05, 1),
        (12, 0.2, 0.05, 1),
        (24, 0.2, 0.05, 1),
        (12, 0.4, 0.1, 2),
    ],
)
def test_bars_are_as_stiff_as_foretold(tmp_path, cells, thick, shift, layers):
    """Within a third: m is one number of a cell, and bars differ at their ends."""
    bar(tmp_path, cells, thick, shift, layers)
    load = 0.1 * YOUNG * 1e-3 * thick**4 / LONG**3
    scene = tmp_path / "bar.tis"
    scene.write_text(TEXT.format(load=load), encoding="utf-8")
    (found,) = tapered(tissuec.compile(scene))
    assert found.code == "W217" and "alternately" in found.message
    foretold = float(found.message.split("about ")[1].split(" times")[0])
    with pytest.warns(tissuec.TissueWarning), tissuec.run(scene, companion="off") as run:
        sunk = 1e3 * float(run.logs["position of far"].value[-1, 2])
    exact = load * LONG**3 / (3.0 * YOUNG * thick**4 / 12.0)
    assert foretold == pytest.approx(exact / sunk, rel=0.33)


def test_boxes_parallelograms_and_rings_are_not_reported(tmp_path):
    """Cells around a ring taper alike: with 32 sides, this one is 7 % too stiff."""
    bar(tmp_path, 12, 0.2, 0.0, 1)
    scene = tmp_path / "bar.tis"
    scene.write_text(TEXT.format(load=1e-6), encoding="utf-8")
    assert not list(tapered(tissuec.compile(scene)))
    ring = (
        "language 1\ntissue gel { Young's modulus = 1 MPa; density = 1000 kg/m^3 }\n"
        "body ring { mesh is thick tube { axis from (0, 0, 0) mm to (0, 0, 1) mm; "
        "inner radius = 9.9 mm; outer radius = 10.1 mm; rings = 2; layers = 1 }\n"
        "tissue is gel }\nenvironment { gravity = (0, 0, 0) m/s^2 }\n"
        "simulate { duration = 1 us }\n"
    )
    assert not list(tapered(compiled_scene(ring)))
