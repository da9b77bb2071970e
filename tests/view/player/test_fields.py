"""Fields of nodes are those of blocks files, on both sides of events."""

import numpy as np
import pytest

import tissuec
from tests.view.player.conftest import Show, grid
from tissuec.analysis.result_scene import anatomy_of_result
from tissuec.core.errors import TissueError
from tissuec.mechanics.deformation import von_mises
from tissuec.results.blocks.fields import CloudMoments, Facts
from tissuec.results.blocks.layout import Cloud, blocks_of
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.drawn_nodes import DrawnNodes
from tissuec.view.player.fields import known_fields
from tissuec.view.player.node_values import FieldValues, read_field, read_fields
from tissuec.view.player.options import Options
from tissuec.view.player.reading import read_film

#: A block of matter, two layers of it, that is drawn out.
BAR = """language 1
tissue gel { spring constant = 10 N/m; density = 1000 kg/m^3; retardation time = 5 ms }
tissue rubber { spring constant = 40 N/m; density = 1000 kg/m^3; retardation time = 5 ms }
body bar {
  mesh is lattice { kind is diamond; reach is second neighbours; cell = 5 mm
    box from (0, 0, 0) mm to (10, 10, 20) mm }
  tissue is gel
  region upper where z > 11 mm { tissue is rubber }
  interface is mean
}
set base = nodes of bar where z < 0.1 mm
set top = nodes of bar where z > 19.9 mm
environment { gravity = (0, 0, 0) m/s^2; damping = 2 mN*s/m }
script {
  at 0 s: fix base
  from 0 s to 20 ms: move top by (0, 0, 3) mm using smooth profile
}
simulate { duration = 40 ms; tolerance = 1e-3 }
output { trajectory every 10 ms }
"""


@pytest.fixture(scope="module")
def bar():
    return tissuec.run(BAR, companion="off")


def nodes_of(trajectory: Trajectory, **options) -> DrawnNodes:
    return DrawnNodes(read_film(trajectory, Options(**options)), trajectory)


class Stretched(Show):
    """A sheet that is drawn out evenly along x, by a tenth more in each frame."""

    def place(self, frame):
        return self.network.position * [1.0 + 0.1 * frame, 1.0, 1.0]


def test_an_even_stretch_has_its_strain_everywhere(shown):
    nodes = nodes_of(shown(Stretched(grid(5, 4), frames=4)))
    stretch = 1.0 + 0.1 * np.arange(4)
    expected = np.broadcast_to(0.5 * (stretch**2 - 1.0)[:, None], (4, 20))
    np.testing.assert_allclose(nodes.strain, expected, rtol=0.0, atol=1e-12)
    assert nodes.stress is None and not nodes.unknown_stress


def test_what_is_pressed_evenly_has_a_strain_below_zero(shown):
    class Pressed(Stretched):
        def place(self, frame):
            return (1.0 - 0.1 * frame) * self.network.position

    nodes = nodes_of(shown(Pressed(grid(5, 4), frames=3)))
    # Across the sheet nothing is known, which is not the largest strain of all.
    assert nodes.strain is not None
    np.testing.assert_allclose(nodes.strain[2], 0.5 * (0.8**2 - 1.0), rtol=0.0, atol=1e-12)


def test_strain_and_stress_are_those_of_blocks(bar):
    nodes = nodes_of(bar)
    anatomy, _ = anatomy_of_result(bar)
    clouds: list[Cloud] = []
    for block in blocks_of(bar, anatomy):
        if block.cloud.kind == "body" and block.cloud not in clouds:
            clouds.append(block.cloud)
    moments = CloudMoments(bar, Facts(bar, anatomy, clouds), clouds)
    rows = np.flatnonzero(~nodes.film.is_side)
    assert nodes.strain is not None and nodes.stress is not None
    for frame in (0, 1, 4):
        (moment,) = moments.at(frame)
        full = moment.strain[0][:, [0, 3, 5, 3, 1, 4, 5, 4, 2]].reshape(-1, 3, 3)
        largest = np.linalg.eigvalsh(full)[:, 2]
        np.testing.assert_allclose(nodes.strain[rows[frame]], largest, atol=1e-12)
        stress = von_mises(moment.stress)
        np.testing.assert_allclose(
            nodes.stress[rows[frame]], stress, rtol=1e-5, atol=1e-6 * max(stress.max(), 1.0)
        )
    assert nodes.strain[-1].max() > 0.1 and nodes.stress[-1].max() > 500.0


def test_stress_is_left_out_where_the_scene_cannot_be_compiled(bar, monkeypatch):
    nodes = nodes_of(bar)
    monkeypatch.setitem(bar.manifest, "sources", {})
    monkeypatch.setattr(bar, "text", "language 1\nbody bar {")
    fields = [one.field.name for one in read_fields(nodes, None)]
    assert fields == ["displacement", "speed", "strain", "force", "tension"]
    with pytest.raises(TissueError, match=r"no stress \(the scene has another digest"):
        read_field(nodes, "stress")


def test_nothing_of_the_cut_is_seen_before_it(sterilisation):
    with Trajectory.open(sterilisation) as trajectory:
        nodes = nodes_of(trajectory)
        film = nodes.film
        before, after = np.flatnonzero(film.is_side & (np.abs(film.times - 0.7) < 1e-9))
        cut = np.unique(film.lines.ends[film.lines.life[:, 1] < 1e8])
        tension, strain = nodes.tension, nodes.strain
        assert tension is not None and strain is not None
        for value in (tension, strain):
            # The nodes have not moved yet: only which springs count has changed.
            change = np.abs(value[after] - value[before])
            assert change[cut].max() > 0.05 * np.abs(value[before]).max()
            assert np.delete(change, cut).max() < 1e-12


def test_what_a_result_lacks_is_said_with_what_it_has(shown):
    nodes = nodes_of(shown(Show(grid(3, 3))))
    with pytest.raises(TissueError, match=r"has no stress; fields of this result: displac"):
        read_field(nodes, "stress")


def test_ranges_hold_98_of_100_nodes_and_signs_are_even():
    field, many = known_fields()["strain"], np.linspace(0.0, 1.0, 1001)[None]
    values = FieldValues.of(field, np.append(many, [[50.0]], axis=1))
    assert (values.low, values.high, values.most) == (0.0, 0.99, 50.0)
    values = FieldValues.of(field, np.append(many, [[-0.7] * 40], axis=1))
    assert (values.low, values.high) == (-0.98, 0.98)
    field = known_fields()["speed"]
    values = FieldValues.of(field, np.append(many, [[-0.7] * 40], axis=1))
    assert values.low == 0.0
    none = FieldValues.of(field, np.zeros((2, 3)))
    assert (none.low, none.high) == (0.0, 1.0)
