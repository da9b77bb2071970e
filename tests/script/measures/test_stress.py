"""Stress of solid elements as a measure, against closed forms of homogeneous deformations."""

import numpy as np
import pytest

import tissuec
from tests.validate.scenes import compiled_scene
from tissuec.core.errors import CompileError
from tissuec.learn.fit.learning import learn
from tissuec.mechanics.state import State
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.snapshot import Snapshot

YOUNG, RATIO = 10e3, 0.3
SHEAR, BULK = YOUNG / 2.0 / (1.0 + RATIO), YOUNG / 3.0 / (1.0 - 2.0 * RATIO)
BLOCK = """language 1
tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }
body block {
  tissue is gel
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 10, 10) mm }
}
set end = nodes of block where x > 14.9 mm
environment { gravity = (0, 0, 0) m/s^2; damping = 1 mN*s/m }
simulate { duration = 1 ms }
"""


def strained(deformation, text=BLOCK):
    """Return a snapshot of a block with one deformation everywhere, and its nodes."""
    network = compiled_scene(text).network
    state = State.start(network, gravity=np.zeros(3), drag=0.0)
    state.position[:] = network.position @ np.asarray(deformation, dtype=float).T
    nodes = np.flatnonzero(network.position[:, 0] > 14.9e-3)
    return Snapshot.of(state), Subject("end", nodes, np.zeros(0, dtype=np.int64))


def seen(name, snapshot, subject, along=None):
    sample = MEASURES[name].sample((subject,), snapshot)
    if along is not None:
        return float(MEASURES[name].along(sample, np.array(along)))
    return float(MEASURES[name].value(sample))


def test_tension_without_lateral_strain_has_its_closed_form():
    """Neo-Hookean with F = diag(λ, 1, 1): σ = μ J^(-5/3) dev B + K ln J/J."""
    for stretch in (0.7, 1.4):
        looked = strained(np.diag([stretch, 1.0, 1.0]))
        shear, bulk = SHEAR * stretch ** (-5.0 / 3.0), BULK * np.log(stretch) / stretch
        deviator = shear * (stretch**2 - 1.0) / 3.0
        along, across = bulk + 2.0 * deviator, bulk - deviator
        assert seen("stress", *looked, (1.0, 0.0, 0.0)) == pytest.approx(along, rel=1e-12)
        assert seen("stress", *looked, (0.0, 0.6, 0.8)) == pytest.approx(across, rel=1e-12)
        assert seen("stress", *looked) == pytest.approx(abs(along - across), rel=1e-12)
        assert seen("pressure", *looked) == pytest.approx(-bulk, rel=1e-12)
        for name, found in (("smallest", min), ("largest", max)):
            value = seen(f"{name} principal stress", *looked)
            assert value == pytest.approx(found(along, across), rel=1e-12)


def test_simple_shear_has_its_closed_form():
    """σ = μ dev B with B = 1 + γ (xy + yx) + γ² xx."""
    amount = 0.5
    looked = strained([[1.0, amount, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    both = np.array([[1.0 + amount**2, amount, 0.0], [amount, 1.0, 0.0], [0.0, 0.0, 1.0]])
    expected = SHEAR * (both - np.trace(both) / 3.0 * np.eye(3))
    rows = MEASURES["stress"].sample((looked[1],), looked[0])
    order = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)]
    assert MEASURES["stress"].columns((), looked[0]) == ("xx", "yy", "zz", "xy", "yz", "xz")
    assert rows == pytest.approx([expected[place] for place in order], abs=1e-9 * SHEAR)
    values = np.linalg.eigvalsh(expected)
    assert seen("largest principal stress", *looked) == pytest.approx(values[-1], rel=1e-12)
    assert seen("smallest principal stress", *looked) == pytest.approx(values[0], rel=1e-12)
    von_mises = np.sqrt(1.5 * (expected**2).sum())
    assert seen("stress", *looked) == pytest.approx(von_mises, rel=1e-12)
    diagonal = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)
    normal = diagonal @ expected @ diagonal
    assert seen("stress", *looked, diagonal) == pytest.approx(normal, rel=1e-12)


def test_a_change_of_volume_alone_is_pressure():
    looked = strained(0.95 * np.eye(3))
    pressure = -BULK * np.log(0.95**3) / 0.95**3
    assert seen("pressure", *looked) == pytest.approx(pressure, rel=1e-12)
    assert seen("stress", *looked) == pytest.approx(0.0, abs=1e-9 * pressure)
    for name in ("largest", "smallest"):
        value = seen(f"{name} principal stress", *looked)
        assert value == pytest.approx(-pressure, rel=1e-12)


def test_nodes_count_by_their_volume_and_a_batch_is_like_its_parts():
    snapshot, end = strained(np.eye(3))
    random = np.random.default_rng(5)
    drawn = snapshot.state.network.position
    moved = drawn + 3e-4 * random.normal(size=(3, *drawn.shape))
    times = np.arange(3.0)
    batch = Snapshot(snapshot.state, times, moved, 0.0 * moved, snapshot.ruptured)
    rows = MEASURES["stress"].sample((end,), batch)
    (field,) = snapshot.state.of_kind("elements")
    for number, position in enumerate(moved):
        total, volume = field.node_stress(position)
        mean = total[end.nodes].sum(axis=0) / volume[end.nodes].sum()
        assert rows[number, 3] == pytest.approx(mean[0, 1], rel=1e-12)
        single = MEASURES["stress"].sample((end,), batch.pick(number))
        assert rows[number] == pytest.approx(single, rel=1e-14)


def test_what_was_cut_off_has_no_stress():
    snapshot, end = strained(np.diag([1.2, 1.0, 1.0]))
    snapshot.state.alive = np.zeros_like(snapshot.state.alive)
    none = Snapshot.of(snapshot.state)
    nobody = Subject("forceps", None, np.zeros(0, dtype=np.int64))
    for subject in (end, nobody):
        assert seen("stress", none, subject) == 0.0
        assert seen("pressure", none, subject) == 0.0
    assert seen("stress", snapshot, nobody) == 0.0


PULLED = BLOCK.replace(
    "simulate { duration = 1 ms }",
    """
set start = nodes of block where x < 0.1 mm
set corner = nodes of block where x < 0.1 mm and y < 0.1 mm
set face = nodes of block where x > 19.9 mm
script {
  at 0 s: fix start
  from 0 s to 60 ms: move face by (2, 0, 0) mm using smooth profile
  when stress(end along (1, 0, 0)) > 0.5 kPa: fix corner
}
simulate { duration = 0.1 s }
output { stress of end every 10 ms; largest principal stress of end every 10 ms
  pressure of end every 10 ms }
expect stress(end along (1, 0, 0)) between 0.9 kPa and 1 kPa at 0.1 s
expect largest principal stress(block) > 0.9 kPa at 0.1 s
expect smallest principal stress(block) between 0 kPa and 0.1 kPa at 0.1 s
expect pressure(block) between -0.4 kPa and -0.3 kPa at 0.1 s
expect stress(end, 0.1 s) > 2 * stress(end, 20 ms)
""",
).replace("cell = 5 mm", "cell = 10 mm")


def test_stress_is_known_to_conditions_logs_and_expectations(tmp_path):
    result = tissuec.run(PULLED, out=tmp_path / "pulled.vtkhdf", companion="off")
    assert result.outcome.startswith("done")
    assert [event.kind for event in result.events].count("fix") == 2
    log = result.logs["stress of end"]
    assert log.columns == ("xx", "yy", "zz", "xy", "yz", "xz") and log.unit == "Pa"
    last = log.value[-1]
    largest = result.logs["largest principal stress of end"].value[-1, 0]
    assert last[0] * (1.0 - 1e-12) <= largest == pytest.approx(last[0], rel=0.05)
    pressure = result.logs["pressure of end"].value[-1, 0]
    assert pressure == pytest.approx(-last[:3].mean(), rel=1e-9)


@pytest.mark.parametrize(
    ("sentence", "said"),
    [
        ("stress(net)", "stress(A) needs nodes of solid elements"),
        ("pressure(corner)", "pressure(A) needs a body, or nodes of solid elements"),
        ("stress(wires)", "stress(A) needs nodes, not springs"),
        ("pressure(block along (1, 0, 0))", "pressure is a single number"),
    ],
)
def test_what_has_no_stress_is_refused(sentence, said):
    text = (
        BLOCK
        + f"""
    body net {{ mesh is explicit; tissue is cord }}
    tissue cord {{ spring constant = 1 N/m; viscosity = 1 mN*s/m; mass = 1 mg }}
    table nodes of net in mm with columns "id x" {{ 1 0; 2 100 }}
    table springs of net with columns "a b" {{ 1 2 }}
    set corner = nodes of net in [1]
    set wires = springs of block where x > 1 mm
    expect {sentence} < 1 Pa at 1 ms
    """
    )
    with pytest.raises(CompileError) as caught:
        compiled_scene(text)
    assert said in str(caught.value)


def test_stress_is_known_to_studies_and_to_learning(tmp_path):
    moved = PULLED.partition("output {")[0]
    (tmp_path / "data.csv").write_text("t,s\n0,0\n")
    (tmp_path / "pulled.tis").write_text(
        moved
        + """
    study pulling {
      vary Young's modulus of gel = [5 kPa, 10 kPa]
      measure normal = stress of end along (1, 0, 0) at 0.1 s
      measure mises = last(stress of end)
    }
    learn gel {
      data "data.csv"
      time using column "t" in s
      fit = stress(end along (1, 0, 0)) using column "s" in Pa
      adjust Young's modulus of gel from 2 kPa to 50 kPa
    }
    """
    )
    table = tissuec.study(tmp_path / "pulled.tis", out=tmp_path / "table.csv")
    along, mises = (table.column(name).numbers for name in ("normal", "mises"))
    assert (mises < along).all() and (mises > 0.8 * along).all()
    assert along[1] / along[0] == pytest.approx(2.0, rel=0.02)
    rows = "".join(f"{0.1 + k * 1e-4},{0.8 * along[1]}\n" for k in range(-3, 1))
    (tmp_path / "data.csv").write_text("t,s\n0,0\n" + rows)
    request = Request.file(tmp_path / "pulled.tis")
    compiled, _ = compile_request(request)
    learned = learn(compiled, compiled.fit_problems[0], request)
    (estimate,) = learned.estimates
    assert estimate.value[0] == pytest.approx(8e3, rel=0.02)
