"""Contact by the area that nodes stand for: as hard on every mesh."""

import numpy as np
import pytest

from tests.validate.scenes import compiled_scene, quantity, validated
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request

SURFACE, LAYER = 5e6, 0.1e-3  # [Pa/m], [m]
SHEET = (
    "sheet {{ corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 10, 0) mm; "
    "columns = {0}; rows = {1} }}; thickness = 1 mm"
)
BLOCK = (
    "lattice {{ kind is sodium chloride; reach is second neighbours; cell = {0} mm; "
    "box from (0, 0, 0) mm to (20, 10, 10) mm }}"
)
THREAD = (
    "thread {{ line from (0, 0, 0) mm to (20, 0, 0) mm; thickness = 0.5 mm; pieces = {0} }}"
)


def text_of(mesh, more="", duration="20 ms"):
    return f"""language 1
tissue gel {{ spring constant = 10 N/m; density = 1000 kg/m^3; retardation time = 5 ms }}
body piece {{ mesh is {mesh}; tissue is gel }}
tool plate {{ kind is plane; point = (0, 0, -0.1) mm; normal = (0, 0, 1) }}
environment {{ gravity = (0, 0, 0) m/s^2; contact is tools only; contact layer = 0.1 mm
  contact surface stiffness = 5 MPa/m; {more} }}
simulate {{ duration = {duration}; tolerance = 1e-4 }}
"""


def pressed(mesh, depth):
    """Return the force on a plane that a body is pressed into by a depth [m]."""
    compiled, _ = compile_request(Request(Source("piece.tis", text_of(mesh))))
    contact, x = compiled.network.contact, compiled.network.position.copy()
    x[: compiled.network.body_nodes, 2] -= 0.1e-3 + depth
    force = np.zeros_like(x)
    contact.add_forces(0.0, x, np.zeros_like(x), force)
    return force[: compiled.network.body_nodes, 2].sum()


@pytest.mark.parametrize(
    ("mesh", "area"),
    [
        *(
            (SHEET.format(columns, rows), 200e-6)
            for columns, rows in ((3, 2), (9, 6), (30, 17))
        ),
        *((THREAD.format(pieces), 10e-6) for pieces in (2, 7, 40)),
    ],
)
@pytest.mark.parametrize("depth", [0.05e-3, 0.3e-3])
def test_the_force_on_a_plane_is_pressure_times_area(mesh, area, depth):
    rise = depth**2 / (2.0 * LAYER) if depth < LAYER else depth - 0.5 * LAYER
    assert pressed(mesh, depth) == pytest.approx(SURFACE * area * rise, rel=1e-9)


# Nodes in edges stand for their part of the sides, too: less with smaller cells.
@pytest.mark.parametrize("cell", [5.0, 2.5, 1.0])
def test_on_the_side_of_a_block_edges_count_what_is_beside(cell):
    depth, length = 0.3e-3, 60e-3  # around the side
    area = 200e-6 + length * cell * 0.5e-3
    force = SURFACE * area * (depth - 0.5 * LAYER)
    assert pressed(BLOCK.format(cell), depth) == pytest.approx(force, rel=0.02)


def test_a_run_agrees_with_scipy():
    mesh = SHEET.format(5, 3).replace("(0, 10, 0)", "(0, 10, 4)")
    text = text_of(mesh, "friction = 0.2", duration="8 ms")
    text = text.replace("gravity = (0, 0, 0)", "gravity = (3, 0, -9.81)")
    found = validated(text + "output { trajectory every 2 ms }", rtol=1e-7)
    assert found.verdict == "kept", found.reasons
    assert np.abs(quantity(found, "force of plate").scale) > 1e-3  # [N]
    assert quantity(found, "force of plate").error < 1e-4


def test_bodies_without_a_surface_are_named():
    text = text_of("explicit") + (
        'table nodes of piece in mm with columns "id x" { 1 0; 2 10 }\n'
        'table springs of piece with columns "a b" { 1 2 }\n'
    )
    text = text.replace("tissue is gel }", "tissue is gel; section = 1 mm^2 }")
    with pytest.raises(CompileError, match="contact surface stiffness needs a surface"):
        compile_request(Request(Source("piece.tis", text)))


def test_both_stiffnesses_are_one_too_many():
    text = text_of(SHEET.format(3, 2), "contact stiffness = 1 N/mm")
    with pytest.raises(CompileError, match="exclude each other"):
        compile_request(Request(Source("piece.tis", text)))


def test_a_net_without_a_surface_is_as_stiff_as_nodes_that_have_one():
    net = (
        "body far { mesh is explicit; tissue is gel; section = 1 mm^2 }\n"
        'table nodes of far in mm with columns "id x y z" { 1 0 0 90; 2 10 0 90 }\n'
        'table springs of far with columns "a b" { 1 2 }\n'
    )
    contact = compiled_scene(text_of(SHEET.format(3, 2)) + net).network.contact
    own = contact.stiffness[contact.owner == 0]
    assert contact.stiffness[contact.owner == 1] == pytest.approx(own.mean(), rel=1e-12)
