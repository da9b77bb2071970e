"""Bodies of elements have exact derivatives, in motion and at rest, by what can be learnt."""

import numpy as np
import pytest

import tissuec
from tissuec.learn.fit.learning import learn
from tissuec.learn.fit.session import prepare
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

CUBE = """language 1
tissue gum {{ Young's modulus = {young} kPa; density = 1000 kg/m^3; Poisson's ratio = 0.45
  {of_tissue} }}
body cube {{ mesh is {mesh}; tissue is gum; {of_body} }}
set foot = nodes of cube where x < 1 mm
set end = nodes of cube where x > 19 mm
environment {{ gravity = (0, 0, 0) m/s^2; mass damping = 100 Hz }}
script {{
  {of_script}at 0 s: fix foot
  from 0 s to 10 ms: move end by (3, 0.5, 0) mm using smooth profile
}}
simulate {{ duration = 30 ms; tolerance = 1e-6 }}
output {{ force(end) every 3 ms }}
"""
SOLID = "lattice { cell = 10 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }"
WALL = (
    "sheet { corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 10, 0) mm; "
    "columns = 3; rows = 2 }"
)
#: Mesh, entries of the tissue and of the body, and what is learnt: its start and its truth.
CASES = {
    "branches": (
        SOLID,
        "relaxing share = {}; relaxation time = {}; second relaxing share = 0.2; "
        "second relaxation time = 20 ms",
        "",
        {"relaxing share": (0.2, 0.3), "relaxation time": (8e-3, 5e-3)},
    ),
    "prestress": (
        SOLID,
        "retardation time = 1 ms; prestress = {}; solid law is yeoh {{ second = {} }}",
        "prestress along (1, 0, 0)",
        {"prestress": (0.04, 0.08), "second": (0.2, 0.4)},
    ),
    "activation": (
        SOLID,
        "retardation time = 1 ms; fibre modulus = {}",
        "fibres = (1, 0.2, 0)",
        {"fibre modulus": (7e4, 9e4)},
    ),
    "prestress of a wall": (
        WALL,
        "retardation time = 1 ms; fibre modulus = 70 kPa; relaxing share = 0.2; "
        "relaxation time = 5 ms; prestress = {}; solid law is ogden {{ exponent = {} }}",
        "thickness = 1 mm; fibres = (1, 0.2, 0); prestress along (1, 0, 0)",
        {"prestress": (0.04, 0.08), "exponent": (5.0, 7.0)},
    ),
    "fibres": (
        SOLID,
        "retardation time = 1 ms; fibre modulus = {}; fibre dispersion = {}",
        "fibres = (1, 0.2, 0)",
        {"fibre modulus": (7e4, 9e4), "fibre dispersion": (0.05, 0.1)},
    ),
    "flow": (
        SOLID,
        "yield stress = {}; flow viscosity = {}",
        "",
        {"yield stress": (2e3, 1.5e3), "flow viscosity": (150.0, 100.0)},
    ),
    "wall": (
        WALL,
        "retardation time = 1 ms; fibre modulus = {}; relaxing share = {}; "
        "relaxation time = 5 ms",
        "thickness = 1 mm; fibres = (1, 0.2, 0)",
        {"fibre modulus": (7e4, 9e4), "relaxing share": (0.2, 0.3)},
    ),
}
OVER_TIME = 'fit = force(end along (1, 0, 0)) using column "force_N" in N'
OVER_WAY = f'displacement of end along (1, 0, 0) using column "u_mm" in mm\n  {OVER_TIME}'
UNITS = {
    "fibre modulus": " Pa", "yield stress": " Pa", "flow viscosity": " Pa*s",
    "relaxation time": " s",
}  # fmt: skip


def text(name, column, learnt=""):
    """Return a scene at the start (0) or in truth (1)."""
    mesh, of_tissue, of_body, numbers = CASES[name]
    values = [f"{pair[column]!r}{UNITS.get(what, '')}" for what, pair in numbers.items()]
    young, of_script = (15, 20)[column], ""
    if name == "activation":
        active = "activate cube with 4 kPa over 60 % to 160 % using smooth profile"
        of_script = f"from 0 s to 20 ms: {active}; "
    of_tissue = of_tissue.format(*values)
    scene = CUBE.format(
        young=young, mesh=mesh, of_tissue=of_tissue, of_body=of_body, of_script=of_script
    )
    return f"{scene}{learnt}"


def block(name, fit, more=""):
    adjusted = ", ".join(["Young's modulus", *CASES[name][3]])
    return f"""learn gum {{
  data = "data.csv"
  {fit}
  adjust = [{adjusted}]
  {more}
  write "learnt.tis"
}}"""


def write(folder, name, fit, more=""):
    """Write a scene and data of its truth; return the request."""
    if "displacement" in fit:  # any data do, as derivatives do not depend on them
        table, head = (
            np.array([[1.0, 0.1], [2.0, 0.2], [2.5, 0.26], [3.0, 0.3]]),
            "u_mm,force_N",
        )
    else:
        log = tissuec.run(text(name, 1), companion="off").logs["force of end"]
        table, head = np.column_stack([log.time, log.value[:, 0]])[1:], "t_s,force_N"
    np.savetxt(folder / "data.csv", table, "%.17g", ",", header=head, comments="")
    path = folder / "scene.tis"
    path.write_text(text(name, 0, block(name, fit, more)))
    return Request.file(path)


@pytest.mark.parametrize(
    ("name", "fit", "more"),
    [
        ("branches", OVER_TIME, ""),
        ("activation", OVER_TIME, ""),
        ("prestress", OVER_WAY, ""),
        *(
            pytest.param(*case, marks=pytest.mark.slow)
            for case in (
                ("prestress", OVER_TIME, "integrator is esdirk43; step = 1 ms"),
                ("branches", OVER_TIME, "integrator is esdirk43; step = 1 ms"),
                ("wall", OVER_TIME, ""),
                ("prestress of a wall", OVER_TIME, ""),
                ("prestress of a wall", OVER_WAY, ""),
                ("flow", OVER_TIME, ""),
                ("branches", OVER_WAY, ""),
                ("fibres", OVER_WAY, ""),
                ("activation", OVER_WAY, ""),
                ("wall", OVER_WAY, ""),
            )
        ),
    ],
)
def test_derivatives_are_those_of_predictions(name, fit, more, tmp_path):
    request = write(tmp_path, name, fit, more)
    compiled, _ = compile_request(request)
    model = prepare(compiled, compiled.fit_problems[0], request).learning[0].model
    assert model.name.startswith("exact derivatives")
    theta = np.zeros(len(CASES[name][3]) + 1)
    model.freeze(theta)
    # Within small steps, few points begin to flow, where derivatives jump.
    found, step = model.jacobian(theta), 1e-5 if name == "flow" else 1e-3
    numbers = ["Young's modulus", *CASES[name][3]]
    for k, direction in enumerate(np.eye(len(theta))):

        def at(part, way=direction):
            return model.predict(theta + part * step * way)

        expected = (8.0 * (at(1) - at(-1)) - at(2) + at(-2)) / (12.0 * step)
        largest = np.abs(expected).max()
        if "displacement" in fit and numbers[k].startswith("relax"):
            assert found[:, k] == pytest.approx(0.0, abs=1e-12)  # at rest all has relaxed
        else:  # numbers of compiled scenes have derivatives by differences, to 1e-8
            assert found[:, k] == pytest.approx(expected, abs=1e-6 * largest)
            assert largest > 0.0
    weights = np.random.default_rng(0).normal(size=len(found))
    backwards = model.gradient(theta, weights)
    assert backwards == pytest.approx(weights @ found, rel=1e-8, abs=1e-9 * abs(found).max())


@pytest.mark.parametrize(
    "name",
    ["branches", *(pytest.param(n, marks=pytest.mark.slow) for n in CASES if n != "branches")],
)
def test_numbers_are_learnt_from_forces_over_time(name, tmp_path):
    request = write(tmp_path, name, OVER_TIME)
    compiled, _ = compile_request(request)
    found = learn(compiled, compiled.fit_problems[0], request)
    assert not found.failure and "exact derivatives of every step" in found.method
    young, *values = (float(one.value[0]) for one in found.estimates)
    # Runs of the data have errors of 1e-6 of the displacement.
    assert young == pytest.approx(20e3, rel=1e-4)
    assert values == pytest.approx([pair[1] for pair in CASES[name][3].values()], rel=1e-3)
