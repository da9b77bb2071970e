"""Elements whose opposite sides turn against each other: which, and when."""

import numpy as np
import pytest

import tissuec
from tests.engine.execution.test_element_inversion import count
from tissuec.compiler.script.initial_state import state_at_start
from tissuec.engine.execution.doubts import WATCHES, Watcher
from tissuec.engine.execution.doubts.turning import TURNED

BAR = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 20 ms }
body bar { mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }
  tissue is gel }
set low = nodes of bar where x < 0.01 mm
set high = nodes of bar where x > 19.99 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: { fix low; hold high }
  from 0 s to 1 s: turn high by ANGLE deg around (1, 0, 0)
    through (20, 5, 5) mm using constant speed
}
simulate { duration = 1 s; tolerance = 1e-2 }
output { torque of high every 1 s }
"""


def twisted(angle):
    """Return a state of the bar, evenly twisted by an angle for each layer [rad]."""
    scene = tissuec.compile(BAR.replace("ANGLE", "10"))
    x = scene.network.position.copy()
    turn = angle * x[:, 0] / 5e-3
    y, z = x[:, 1] - 5e-3, x[:, 2] - 5e-3
    x[:, 1] = 5e-3 + y * np.cos(turn) - z * np.sin(turn)
    x[:, 2] = 5e-3 + y * np.sin(turn) + z * np.cos(turn)
    return scene, x


def looked(scene, position):
    state = state_at_start(scene)
    return count(WATCHES[TURNED].of(scene.network, scene.plan).look(state, position))


TO_AND_FRO = (
    BAR.replace(
        "}\nsimulate { duration = 1 s",
        """  from 1 s to 2 s: turn high by -ANGLE deg around (1, 0, 0)
    through (20, 5, 5) mm using constant speed
}
simulate { duration = 2 s""",
    )
    .replace("torque of high every 1 s", "trajectory every 2 s")
    .replace("ANGLE", "480")
)


@pytest.mark.parametrize(("degrees", "which"), [(0, 0), (89.9, 0), (90.1, 16), (170, 16)])
def test_layers_are_counted_from_90_degrees_on(degrees, which):
    scene, x = twisted(np.radians(degrees))
    # No element is inside out, also at 170 degrees.
    assert looked(scene, x) == which
    inside_out = WATCHES["elements inside out"].of(scene.network, scene.plan)
    assert count(inside_out.look(state_at_start(scene), x)) == 0


def test_nothing_is_turned_before_nodes_have_moved_by_the_margin():
    scene, x = twisted(np.radians(60.0))
    (body,) = WATCHES[TURNED].of(scene.network, scene.plan)._bodies
    (part,) = body._tests
    alive = scene.network.present
    which, margin = part.found(x, alive)
    assert not len(which)
    # An edge of 5 mm, of 30 degrees that are left: 2.5 mm sin 15°. Nothing else turns.
    assert margin == pytest.approx(2.5e-3 * np.sin(np.radians(15.0)), rel=1e-9)
    rng = np.random.default_rng(3)
    for _ in range(200):
        way = rng.normal(size=x.shape)
        way *= margin / np.linalg.norm(way, axis=1, keepdims=True)
        assert not len(part.found(x + way, alive)[0])


def test_a_turn_is_reported_with_its_element_time_and_line():
    """Layers of a bar that is turned evenly by 480° in 1 s are at 90° after 0.75 s."""
    run = tissuec.run(BAR.replace("ANGLE", "480"), companion="off")
    (doubt,) = (one for one in run.doubts if one.kind == TURNED)
    # Layers at glued ends turn less than those between them; there are no outputs on the way.
    assert 0.65 < doubt.time < 0.75 + 1 / 64
    assert "hexahedron" in doubt.where
    assert doubt.place.endswith(":10")


def test_a_turn_that_comes_and_goes_between_outputs_is_reported():
    run = tissuec.run(TO_AND_FRO, companion="off")
    (doubt,) = (one for one in run.doubts if one.kind == TURNED)
    assert 0.65 < doubt.time < 0.75 + 1 / 64
    assert (doubt.most, doubt.last) == (16, 0)
    assert doubt.where.startswith("in hexahedron")
    assert doubt.place.endswith(":10")


def test_what_is_observed_does_not_change_what_happens(monkeypatch):
    def end():
        run = tissuec.run(TO_AND_FRO, companion="off")
        return run.doubts, run.position[-1]

    doubts, seen = end()
    monkeypatch.setattr(Watcher, "follow", lambda *_, **__: np.inf)
    none, unseen = end()
    assert {TURNED} <= {one.kind for one in doubts}
    assert not {one.kind for one in none} & {TURNED, "inside out"}
    assert np.array_equal(seen, unseen)


def test_a_turn_that_elements_represent_is_no_doubt():
    run = tissuec.run(
        BAR.replace("ANGLE", "240").replace("every 1 s", "every 10 ms"), companion="off"
    )
    assert not [one for one in run.doubts if one.kind == TURNED]
