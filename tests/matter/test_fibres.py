"""Tissue with fibres is as stiff along them as said, and hardly stiffer across."""

import numpy as np
import pytest

from tests.every import every
from tests.matter.elastic import drawn_out, scene, stiffness
from tissuec.core.errors import CompileError
from tissuec.matter.linear import solution

YOUNG, FIBRE = 10e3, 200e3
TISSUE = (
    f"Young's modulus = {YOUNG} Pa; fibre modulus = {FIBRE} Pa; density = 1000 kg/m^3; "
    "retardation time = 2 ms"
)
BAR = (
    "mesh is lattice { kind is KIND; reach is second neighbours; cell = 5 mm; "
    "box from (0, 0, 0) mm to (40, 20, 20) mm }"
)


@pytest.mark.parametrize("kind", ["sodium chloride", "caesium chloride"])
def test_a_bar_is_as_stiff_along_its_fibres_as_they_are(kind):
    for direction, axis in (((1, 0, 0), 0), ((0, 0, 2), 2)):
        network, plan = scene(TISSUE, BAR.replace("KIND", kind) + f"; fibres = {direction}")
        size = np.ptp(network.position, axis=0)
        force, u = drawn_out(network, plan, axis)
        section = np.prod(size) / size[axis]
        assert force == pytest.approx(FIBRE * section, rel=0.01)
        # What is stretched by 1 becomes narrower by 1/4, as without fibres.
        other = (axis + 1) % 3
        ratio = -np.polyfit(network.position[:, other], u[:, other], 1)[0]
        assert ratio == pytest.approx(0.25, abs=0.02)


def test_across_its_fibres_a_bar_is_hardly_stiffer_than_without():
    # C = E/2.5 (sym) + β f f f f: as β grows, the modulus across goes from 2.5 to 8/3 μ.
    network, plan = scene(
        TISSUE, BAR.replace("KIND", "sodium chloride") + "; fibres = (0, 1, 0)"
    )
    force, _ = drawn_out(network, plan, 0)
    shear, added = YOUNG / 2.5, FIBRE - YOUNG
    c = shear * (np.ones((3, 3)) + 2.0 * np.eye(3))
    c[1, 1] += added
    expected = 1.0 / np.linalg.inv(c)[0, 0]
    assert YOUNG < expected < 1.07 * YOUNG
    assert force == pytest.approx(expected * 4e-4, rel=0.02)


def test_fibres_go_with_any_poisson_ratio():
    for ratio in (0.35, 0.45):
        network, plan = scene(
            TISSUE + f"; Poisson's ratio = {ratio}",
            BAR.replace("KIND", "sodium chloride") + "; fibres = (1, 0, 0)",
        )
        force, u = drawn_out(network, plan, 0)
        assert force == pytest.approx(FIBRE * 4e-4, rel=0.01)
        other = -np.polyfit(network.position[:, 1], u[:, 1], 1)[0]
        assert other == pytest.approx(ratio, abs=0.02)


@pytest.mark.parametrize(("direction", "axis"), [((1, 0, 0), 0), ((0, 3, 0), 1)])
def test_a_sheet_is_as_stiff_along_its_fibres_as_they_are(direction, axis):
    network, plan = scene(
        TISSUE,
        "mesh is sheet { corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = "
        "(0, 20, 0) mm; columns = 9; rows = 5; diagonals is both }; thickness = 1 mm; "
        f"fibres = {direction}",
    )
    sides = (0.04, 0.02)
    force, _ = drawn_out(network, plan, axis)
    assert force == pytest.approx(FIBRE * 1e-3 * sides[1 - axis], rel=1e-4)
    force, _ = drawn_out(network, plan, 1 - axis)
    # In a plane, from 8/3 to 3 μ.
    assert YOUNG < force / (1e-3 * sides[axis]) < 9.0 / 8.0 * YOUNG


def test_a_tube_has_fibres_along_or_around():
    radius, pressure = 6e-3, 1.0
    for word, around in (("axial", YOUNG), ("circumferential", FIBRE)):
        network, plan = scene(
            TISSUE,
            "mesh is tube { axis from (0, 0, 0) mm to (60, 0, 0) mm; radius = 6 mm; "
            "rings = 16; sides = 10; diagonals is both }; thickness = 1 mm; "
            f"fibres is {word}",
        )
        perimeter = 20.0 * radius * np.sin(np.pi / 10.0)
        along = FIBRE if word == "axial" else YOUNG
        force, _ = drawn_out(network, plan, 0)
        assert force / (1e-3 * perimeter) == pytest.approx(along, rel=0.13)
        if along == FIBRE:
            assert force / (1e-3 * perimeter) == pytest.approx(along, rel=1e-3)
        x = network.position
        outward = x * np.array([0.0, 1.0, 1.0]) / radius
        share = np.where(np.isin(x[:, 0], (0.0, x[:, 0].max())), 0.5, 1.0)[:, None]
        load = pressure * share * outward * perimeter * 0.06 / (10 * 15)
        u = solution(stiffness(network, plan), load.reshape(-1, 1)).reshape(-1, 3)
        widened = np.einsum("ni,ni->n", u, outward).mean() / radius
        stiff = pressure * radius / (1e-3 * widened)
        if around == FIBRE:
            assert stiff == pytest.approx(around, rel=1e-3)
        else:
            assert YOUNG < stiff < 9.0 / 8.0 * YOUNG


def test_a_thread_runs_along_its_fibres():
    network, _ = scene(
        TISSUE,
        "mesh is thread { line from (0, 0, 0) mm to (40, 0, 0) mm; thickness = 2 mm; "
        "pieces = 4 }",
    )
    part = network.threads["piece"].pieces
    assert network.springs.stiffness[part] == pytest.approx(FIBRE * np.pi * 1e-6 / 0.01)


def test_a_spring_along_breaks_at_its_strain_and_strength_is_that_along_fibres():
    body = BAR.replace("KIND", "sodium chloride") + "; fibres = (1, 0, 0); rupture is allowed"
    by_strain, _ = scene(TISSUE + "; breaking strain = 10 %", body)
    by_stress, _ = scene(TISSUE + f"; strength = {0.1 * FIBRE} Pa", body)
    assert by_stress.springs.strength == pytest.approx(by_strain.springs.strength)


WRONG = {
    "fibres without a direction": (TISSUE, BAR, "TIS304"),
    "softer along than across": (
        TISSUE.replace("fibre modulus = 200", "fibre modulus = 2"),
        BAR + "; fibres = (1, 0, 0)",
        "TIS309",
    ),
    "around the axis of a bar": (TISSUE, BAR + "; fibres is axial", "TIS309"),
    "no direction at all": (TISSUE, BAR + "; fibres = (0, 0, 0)", "TIS308"),
    "a direction without fibres": (
        TISSUE.replace("fibre modulus = 200000.0 Pa; ", ""),
        BAR + "; fibres = (1, 0, 0)",
        "TIS306",
    ),
    "fibres in springs one by one": (
        "spring constant = 1 N/m; viscosity = 0 N*s/m; mass = 1 g; fibre modulus = 1 MPa",
        BAR + "; fibres = (1, 0, 0)",
        "TIS304",
    ),
    "unknown word": (TISSUE, BAR + "; fibres is spiral", "TIS305"),
    "across a sheet": (
        TISSUE,
        "mesh is sheet { corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm; second edge = "
        "(0, 20, 0) mm; columns = 9; rows = 5; diagonals is both }; thickness = 1 mm; "
        "fibres = (0, 0, 1)",
        "TIS309",
    ),
    "in a sphere": (
        TISSUE,
        "mesh is sphere { centre = (0, 0, 0) mm; radius = 5 mm; subdivisions = 1 }; "
        "thickness = 1 mm; fibres = (0, 0, 1)",
        "TIS309",
    ),
}


@every("name", WRONG)
def test_fibres_that_cannot_be_are_told(name):
    tissue, body, code = WRONG[name]
    with pytest.raises(CompileError) as caught:
        scene(tissue, body.replace("KIND", "sodium chloride"))
    assert [one.code for one in caught.value.diagnostics if one.severity == "error"] == [code]
