"""Ambient damping by mass and by surface is the same on every mesh."""

import numpy as np
import pytest

import tissuec
from tests.engine.running import Bench
from tests.hand_net import chain
from tests.validate.scenes import compiled_scene, validated
from tissuec.core.errors import CompileError
from tissuec.core.structs import replace

FALLING = """language 1
tissue skin { spring constant = 20 N/m; density = 1000 kg/m^3; retardation time = 5 ms }
body piece { mesh is MESH; tissue is skin; thickness = 2 mm }
environment { gravity = (0, 0, -9.81) m/s^2; DAMPING }
simulate { duration = 30 ms; tolerance = 1e-6 }
output { trajectory every 10 ms; energy every 10 ms }
"""
SHEET = (
    "sheet { corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = (0, 20, 0) mm; "
    "columns = COLUMNS; rows = ROWS; diagonals is both }"
)


def test_each_node_is_braked_by_its_own_number():
    # v = v0 exp(-d t / m)
    net = chain(4, mass=[1.0, 2.0, 0.5, 1.0], stiffness=0.0, velocity=[0.0, 1.0, 0.0])
    own = np.array([0.0, 1.0, 0.3, 2.0])
    bench = Bench(replace(net, drag=own), 2.0, tolerance=1e-9, drag=0.25, ledger=True)
    ran = bench.run()
    expected = np.exp(-np.outer(ran.time, (0.25 + own) / net.mass))
    assert ran.velocity[:, :, 1] == pytest.approx(expected, abs=1e-8)
    lost = 0.5 * (net.mass * (1.0 - expected**2)).sum(axis=1)
    assert ran.dissipated == pytest.approx(lost, abs=1e-7)


@pytest.mark.parametrize(
    ("damping", "rate"),
    [("mass damping = 1 / 20 ms", 50.0), ("surface damping = 80 Pa*s/m", 80.0 / (1000 * 2e-3))],
)
@pytest.mark.parametrize(("columns", "rows"), [(3, 2), (9, 5)])
def test_a_sheet_falls_as_theory_says_whatever_its_mesh(damping, rate, columns, rows):
    # v = g/r (1 - exp(-r t)); nothing is stretched, since all nodes fall alike
    mesh = SHEET.replace("COLUMNS", str(columns)).replace("ROWS", str(rows))
    run = tissuec.run(FALLING.replace("MESH", mesh).replace("DAMPING", damping))
    time = run.times
    fallen = 9.81 / rate * (time - (1.0 - np.exp(-rate * time)) / rate)
    height = run.position[:][:, :, 2]
    moved = height - height[0]
    assert moved == pytest.approx(-np.broadcast_to(fallen[:, None], moved.shape), abs=1e-8)


def test_a_thread_has_the_surface_of_a_cylinder():
    mesh = "thread { line from (0, 0, 0) mm to (40, 0, 0) mm; thickness = 2 mm; pieces = 8 }"
    text = FALLING.replace("MESH", mesh).replace("; thickness = 2 mm }\nenv", " }\nenv")
    text = text.replace("DAMPING", "surface damping = 3 Pa*s/m; mass damping = 1 / 0.5 s")
    network = compiled_scene(text).network
    assert network.drag.sum() == pytest.approx(
        3.0 * np.pi * 2e-3 * 0.04 + 2.0 * network.mass.sum()
    )


def test_scipy_agrees_on_a_sheet_that_is_braked_by_its_surface():
    mesh = SHEET.replace("COLUMNS", "5").replace("ROWS", "3")
    text = FALLING.replace("MESH", mesh).replace("DAMPING", "surface damping = 40 Pa*s/m")
    text = text.replace("simulate", "set side = nodes of piece where x < 1 mm\n"
                        "script { at 0 s: fix side }\nsimulate")  # fmt: skip
    found = validated(text)
    assert found.verdict == "kept", found.reasons


def test_what_has_no_surface_is_told():
    text = (
        FALLING.replace("; thickness = 2 mm", "; section = 1 mm^2")
        .replace("MESH", "explicit")
        .replace("DAMPING", "surface damping = 40 Pa*s/m")
    )
    text += (
        'table nodes of piece in mm with columns "id x" { 1 0; 2 10 }\n'
        'table springs of piece with columns "a b" { 1 2 }\n'
    )
    with pytest.raises(CompileError) as caught:
        compiled_scene(text)
    assert [found.code for found in caught.value.diagnostics] == ["TIS306"]
