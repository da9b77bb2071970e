"""Area and pressure of contact: together they are the force."""

import numpy as np
import pytest

import tissuec
from tests.findings import finding_of
from tests.validate.scenes import compiled_scene

PRESSED = """language 1
tissue gel { Young's modulus = 20 kPa; Poisson's ratio = 0.3; density = 1500 kg/m^3 }
body block {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 10, 10) mm }; tissue is gel
}
tool plate { kind is plane; point = (0, 0, 10.1) mm; normal = (0, 0, -1) }
environment {
  gravity = (0, 0, 0) m/s^2; contact is tools only
  symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)
}
script { from 0 s to 0.1 s: move plate by (0, 0, -2.1) mm using constant speed }
simulate { duration = 0.1 s; integrator is equilibrium; step = 50 ms }
output {
  contact area(plate) every 50 ms; contact pressure(plate) every 50 ms; force(plate) every 50 ms
  trajectory with [contact pressure] every 50 ms
  largest(contact pressure of block) every 50 ms
}
"""
PLATE = "tool plate { kind is plane; point = (0, 0, 10.1) mm; normal = (0, 0, -1) }"
STACKED = (
    PRESSED.replace(PLATE,
                    "tissue firm like gel { Young's modulus = 60 kPa }\n"
                    "body plate { mesh is lattice { cell = 5 mm; "
                    "box from (0, 0, 10) mm to (10, 10, 20) mm }; tissue is firm }\n"
                    "set top = nodes of plate where z == 20 mm")
    .replace("tools only", "bodies too").replace("move plate", "move top")
    .replace("force(plate)", "force(top) every 50 ms; contact area(block) every 50 ms; "
             "contact pressure(block)")
)  # fmt: skip


def areas_of_nodes(run, body, height):
    """Return a third of the area of the triangles around each node of a face [m²]."""
    network = run.network
    own = network.skin[
        np.all(np.abs(network.position[network.skin, 2] - height) < 1e-9, axis=1)
    ]
    own = own[np.isin(own, body).all(axis=1)]
    a, b, c = np.moveaxis(run.position[-1][own], 1, 0)
    third = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0
    return np.bincount(own.ravel(), np.repeat(third, 3), len(run.position[-1]))


def test_area_times_pressure_is_the_force_of_a_plate(tmp_path):
    run = tissuec.run(PRESSED, out=tmp_path / "pressed.vtkhdf", companion="off")
    area, pressure = (
        run.logs[f"contact {one} of plate"].value.ravel() for one in ("area", "pressure")
    )
    force = -run.logs["force of plate"].value[:, 2]
    # The plate is flat, so that all normals are alike: the same sum, but for rounding.
    np.testing.assert_allclose(area * pressure, force, rtol=1e-12, atol=1e-15)
    # The lid widens by Poisson's ratio: the area is that of its present outline.
    lid = run.position[-1][np.abs(run.network.position[:27, 2] - 10e-3) < 1e-9]
    corners = lid[np.lexsort(lid[:, :2].T)].reshape(3, 3, 3)
    ring = [*corners[0], *corners[1:, 2], *corners[2, 1::-1], corners[1, 0]]
    x, y = np.array(ring)[:, :2].T
    outline = 0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
    assert area[0] == 0.0
    # The lid is nearly flat: its slopes, below 2 %, add less than their square.
    assert area[-1] == pytest.approx(outline, rel=4e-4)
    assert area[-1] > 1.1 * 1e-4
    shared = areas_of_nodes(run, np.arange(27), 10e-3)
    assert run.fields["contact pressure"][-1] @ shared == pytest.approx(force[-1], rel=1e-6)
    peak = run.logs["largest contact pressure of block"].value[:, 0]
    assert np.array_equal(peak, run.fields["contact pressure"][:].max(axis=1))
    assert peak[-1] > pressure[-1] > 0.0


def test_both_faces_of_two_bodies_bear_the_whole_force(tmp_path):
    run = tissuec.run(STACKED, out=tmp_path / "stacked.vtkhdf", companion="off")
    force = -run.logs["force of top"].value[-1, 2]
    for body, nodes in (("block", np.arange(27)), ("plate", np.arange(27, 54))):
        area, pressure = (
            run.logs[f"contact {one} of {body}"].value.ravel()[-1]
            for one in ("area", "pressure")
        )
        # Normals tilt by a few degrees, of which the cosine is lost.
        assert area * pressure == pytest.approx(force, rel=2e-3)
        shared = areas_of_nodes(run, nodes, 10e-3)
        assert run.fields["contact pressure"][-1] @ shared == pytest.approx(force, rel=2e-3)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("contact is tools only", "contact is off"),
        ("tools only", "tools only; contact places is nodes"),
    ],
)
def test_a_field_of_contact_without_faces_is_refused(old, new):
    text = PRESSED.replace(old, new).replace("contact area(plate) every 50 ms; ", "")
    text = text.replace("contact pressure(plate) every 50 ms; ", "")
    text = text.replace("  largest(contact pressure of block) every 50 ms\n", "")
    found = finding_of(compiled_scene, text)
    assert found.message == "contact pressure is always 0: nothing touches faces of elements"
