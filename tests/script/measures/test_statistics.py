"""Statistics of fields over sets and bodies, against closed forms and weights by hand."""

import numpy as np
import pytest

import tissuec
from tests.every import every
from tests.script.measures.test_stress import BLOCK, BULK, SHEAR, strained
from tests.validate.scenes import compiled_scene
from tissuec.compiler.measures.statistics import FieldStatistic, field_named, names_of_fields
from tissuec.core.errors import CompileError
from tissuec.learn.fit.learning import learn
from tissuec.mechanics.state import State
from tissuec.pipeline import compile_request
from tissuec.scene.request import Request
from tissuec.script.measures import MEASURES, Subject
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.measures.statistics import STATISTICS, statistic_of

EVERY = Subject("block", np.arange(63), np.zeros(0, dtype=np.int64))


def seen(statistic, name, snapshot, share=0.5, subject=EVERY):
    measure = FieldStatistic(statistic, name, share)
    return measure.value(measure.sample((subject,), snapshot))


@pytest.mark.parametrize("statistic", STATISTICS)
def test_an_even_stretch_has_the_same_number_everywhere(statistic):
    """Neo-Hookean with F = diag(λ, 1, 1): σ = μ J^(-5/3) dev B + K ln J/J."""
    stretch = 1.4
    snapshot, _ = strained(np.diag([stretch, 1.0, 1.0]))
    bulk = BULK * np.log(stretch) / stretch
    deviator = SHEAR * stretch ** (-5.0 / 3.0) * (stretch**2 - 1.0) / 3.0
    expected = {
        "von Mises stress": 3.0 * deviator,
        "largest principal stress": bulk + 2.0 * deviator,
        "smallest principal stress": bulk - deviator,
        "hydrostatic pressure": -bulk,
        "largest principal strain": stretch - 1.0,
        "smallest principal strain": 0.0,
        "modulus": 10e3,
        "plastic strain": 0.0,
    }
    for name, value in expected.items():
        assert seen(statistic, name, snapshot) == pytest.approx(value, rel=1e-11, abs=1e-12)


def test_the_strain_of_elements_is_the_largest_in_any_direction():
    """That of simple shear by γ has λ - 1/λ = γ; edges have less in oblique directions."""
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    for deformation, largest in (
        (np.diag([1.1, 0.8, 1.0]), 0.2),
        (turn @ np.diag([1.1, 0.95, 1.0]) @ turn.T, 0.1),
        (
            np.array([[1.0, 0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
            0.25 + 1.0625**0.5 - 1.0,
        ),
    ):  # of simple shear, λ - 1/λ = γ
        snapshot, _ = strained(deformation)
        found = MEASURES["strain"].sample((EVERY,), snapshot)
        assert found == pytest.approx(largest, rel=1e-12)


def test_every_field_of_elements_is_there():
    fields = {name for name in names_of_fields() if field_named(name).of_points}
    assert {"von Mises stress", "modulus", "largest principal strain"} < fields


def test_numbers_of_points_count_by_their_volumes():
    """Where x > 10 mm, the block is stretched by a quarter: F = diag(1.25, 1, 1)."""
    snapshot, _ = strained(np.eye(3))
    place = snapshot.state.network.position
    longer = place + np.maximum(place - 10e-3, 0.0) * [0.25, 0.0, 0.0]
    times = np.arange(2.0)
    moved = np.stack([place, longer])
    batch = Snapshot(snapshot.state, times, moved, 0.0 * moved, snapshot.ruptured)
    whole = Subject("block", np.arange(len(place)), np.zeros(0, dtype=np.int64))

    def both(statistic, share=0.5):
        measure = FieldStatistic(statistic, "largest principal strain", share)
        return measure.sample((whole,), batch)[..., 0]

    assert both("largest") == pytest.approx([0.0, 0.25], abs=1e-12)
    assert both("smallest") == pytest.approx([0.0, 0.0], abs=1e-12)
    assert both("average") == pytest.approx([0.0, 0.125], abs=1e-12)
    assert both("percentile", 0.5) == pytest.approx([0.0, 0.0], abs=1e-12)
    assert both("percentile", 0.51) == pytest.approx([0.0, 0.25], abs=1e-12)
    # Elements of a set are those that are whole in it.
    nodes = np.flatnonzero(place[:, 0] > 9.9e-3)
    half = Subject("half", nodes, np.zeros(0, dtype=np.int64))
    some = Subject("some", np.flatnonzero(place[:, 0] > 19.9e-3), half.lines)
    measure = FieldStatistic("smallest", "largest principal strain")
    assert measure.sample((half,), batch)[1, 0] == pytest.approx(0.25, rel=1e-12)
    assert measure.sample((half,), batch.pick(1))[0] == pytest.approx(0.25, rel=1e-12)
    assert np.isnan(measure.sample((some,), batch)).all()


def test_percentiles_are_those_of_numpy_where_all_weigh_alike():
    random = np.random.default_rng(3)
    numbers, weights = random.normal(size=(4, 57)), np.full(57, 0.1)
    for share in (0.0, 0.07, 0.5, 0.95, 1.0):
        expected = np.quantile(numbers, share, axis=1, method="inverted_cdf")
        assert np.array_equal(statistic_of("percentile", numbers, weights, share), expected)
    twice = np.array([2.0, 1.0, 1.0])
    assert statistic_of("percentile", np.array([3.0, 1.0, 2.0]), twice, 0.5) == 2.0
    assert statistic_of("percentile", np.array([3.0, 1.0, 2.0]), twice, 0.51) == 3.0
    assert statistic_of("average", np.array([3.0, 1.0, 2.0]), twice, 0.0) == 2.25


LAME = """language 1
tissue gel {{ Young's modulus = 100 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3 }}
body wall {{
  mesh is thick tube {{
    axis from (0, 0, 0) mm to (0, 0, 1) mm; inner radius = 10 mm; outer radius = 20 mm
    rings = 2; sides = {sides}; layers = {layers}; part is quarter
  }}
  tissue is gel
}}
environment {{
  gravity = (0, 0, 0) m/s^2
  symmetric about plane through (0, 0, 0) mm facing (0, 0, 1)
  symmetric about plane through (0, 0, 1) mm facing (0, 0, -1)
  symmetric about plane through (0, 0, 0) mm facing (1, 0, 0)
  symmetric about plane through (0, 0, 0) mm facing (0, 1, 0)
}}
script {{ at 0 s: press inside of wall with 10 Pa }}
simulate {{ duration = 1 s; integrator is equilibrium; step = 1 s }}
output {{ {output} }}
"""
PEAK = "largest(largest principal stress of wall) every 1 s"
MISES = "largest(von Mises stress of wall) every 1 s"


def pressed(layers, tmp_path, output=PEAK + "; " + MISES):
    text = LAME.format(layers=layers, sides=8 * layers, output=output)
    return tissuec.run(text, out=tmp_path / "w", companion="off")


def test_the_peak_of_a_pressed_tube_converges_to_that_of_lame(tmp_path):
    """σ = p a²/(b² - a²) (1 ± b²/r²) around and across, and along z ν times both."""
    a, b, pressure, ratio = 10.0, 20.0, 10.0, 0.3
    scale = pressure * a**2 / (b**2 - a**2)
    errors = []
    for layers in (4, 8):
        logs = pressed(layers, tmp_path).logs
        depth = 0.5 * (1.0 - 1.0 / np.sqrt(3.0)) * (b - a) / layers
        radius = a + depth  # of the first point of Gauss
        around, across = scale * (1.0 + (b / radius) ** 2), scale * (1.0 - (b / radius) ** 2)
        along = ratio * (around + across)
        mises = np.sqrt(
            0.5 * ((around - across) ** 2 + (across - along) ** 2 + (along - around) ** 2)
        )
        peak, equivalent = (
            logs[f"largest {name} of wall"].value[-1, 0]
            for name in ("largest principal stress", "von Mises stress")
        )
        errors.append((abs(peak / around - 1.0), abs(equivalent / mises - 1.0)))
    # Strain across a layer is even within a cell of first order, and right in its middle, so
    # that errors at the points fall with the size of the cells.
    assert max(errors[0]) < 0.05
    assert errors[1][0] < 0.6 * errors[0][0]
    assert errors[1][1] < 0.6 * errors[0][1]


def test_what_is_observed_changes_nothing(tmp_path):
    runs = []
    for output in (PEAK, f"trajectory with [von Mises stress] every 1 s; {PEAK}"):
        every = "trajectory every 1 s; " if "trajectory" not in output else ""
        runs.append(np.array(pressed(4, tmp_path, every + output).position))
    bare = np.array(pressed(4, tmp_path, "trajectory every 1 s").position)
    assert np.array_equal(runs[0], bare)
    assert np.array_equal(runs[1], bare)


def test_frames_have_the_mean_around_nodes(tmp_path):
    result = pressed(4, tmp_path, f"trajectory with [von mises stress] every 1 s; {MISES}")
    field = result.fields["von Mises stress"]
    assert field.unit == "Pa"
    peak = result.logs["largest von Mises stress of wall"].value[-1, 0]
    shown = np.array(field)[-1]
    assert 0.8 * peak < shown.max() < peak
    assert shown.min() > 0.0


NET = """
body net { mesh is explicit; tissue is cord }
tissue cord { spring constant = 1 N/m; viscosity = 1 mN*s/m; mass = 1 mg }
table nodes of net in mm with columns "id x" { 1 0; 2 100; 3 300 }
table springs of net with columns "a b" { 1 2; 2 3 }
set corner = nodes of net in [1]
set face = nodes of block where x < 0.1 mm
set edges = springs of block where x < 0.1 mm
"""


@pytest.mark.parametrize(
    ("sentence", "said"),
    [
        ("largest(von Mises stress of net)", "needs nodes of solid elements"),
        ("largest(von Mises stress of face)", "needs elements all of whose nodes are in A"),
        ("strain(face)", "strain(A) needs springs, or elements all of whose nodes are in A"),
        ("strain(edges)", "strain(A) needs springs, or elements all of whose nodes are in A"),
        ("largest(tension of block)", "needs springs that bear a tension"),
        ("largest(stress of block)", "write von Mises stress, largest principal stress"),
        ("largest(von Mises tress of block)", 'did you mean "von Mises stress"?'),
        ("largest(block)", "the form is largest(FIELD of A)"),
        ("largest(stress(block))", "over time, a study has max(stress(block))"),
        ("percentile(von Mises stress of block)", "percentile(FIELD of A, 95 %)"),
        ("percentile(von Mises stress of block, 95)", 'write "95 %"'),
        ("percentile(von Mises stress of block, 1 mm)", "must be a plain number"),
        ("largest(contact pressure of block)", "is always 0: contact is off"),
        ("largest(von Mises stress of block along (1, 0, 0))", "the form is"),
    ],
)  # fmt: skip
def test_what_has_no_statistic_is_refused(sentence, said):
    with pytest.raises(CompileError) as caught:
        compiled_scene(f"{BLOCK}{NET}expect {sentence} == 0 at 1 ms")
    assert said in str(caught.value)


def test_nodes_and_springs_have_statistics():
    text = f"""{BLOCK}{NET}
    set tip = nodes of net in [3]
    script {{ at 0 s: {{ fix corner; fix tip }} }}
    output {{ largest(tension of net) every 1 ms; average(speed of block) every 1 ms
      smallest(displacement of net) every 1 ms }}
    expect largest(speed of block) == 0 m/s over run
    """
    compiled = compiled_scene(text)
    state = compiled.plan.start(compiled.network)
    place = state.position
    place[-1] += [0.02, 0.0, 0.0]  # the longer spring bears 20 mN
    place[-2] += [0.005, 0.0, 0.0]  # of which the other one takes 5 mN
    snapshot = Snapshot.of(state)
    found = [log.measure.sample(log.subjects, snapshot)[0] for log in compiled.plan.output.logs]
    assert found == pytest.approx([15e-3, 0.0, 0.0], abs=1e-12)


PULLED = (
    BLOCK.replace("duration = 1 ms", "duration = 0.1 s; integrator is equilibrium")
    + """
set start = nodes of block where x < 0.1 mm
set face = nodes of block where x > 19.9 mm
script {
  at 0 s: fix start
  from 0 s to 0.1 s: move face by (1, 0, 0) mm using constant speed
  when largest(largest principal strain of block) > 4 %: free start
}
study hardness {
  vary Young's modulus of gel = [5 kPa, 10 kPa]
  measure peak = max(largest(von Mises stress of block)) until 50 ms
  measure most = percentile(von Mises stress of block, 95 %) at 50 ms
}
learn gel {
  data "data.csv"
  time using column "t" in s
  fit = largest(von Mises stress of block) using column "s" in Pa
  adjust Young's modulus of gel from 2 kPa to 50 kPa
}
"""
)


def test_statistics_are_known_to_conditions_studies_and_learning(tmp_path):
    (tmp_path / "data.csv").write_text("t,s\n0,0\n0.05,0\n")
    path = tmp_path / "pulled.tis"
    path.write_text(PULLED)
    with tissuec.run(path, out=tmp_path / "w.vtkhdf", companion="off") as result:
        assert "free" in [event.kind for event in result.events]
    table = tissuec.study(path, out=tmp_path / "table.csv")
    peak, most = (table.column(name).numbers for name in ("peak", "most"))
    assert peak[1] / peak[0] == pytest.approx(2.0, rel=1e-6)
    assert (most <= peak).all() and (most > 0.5 * peak).all()
    path.write_text(
        PULLED.replace(
            "  when largest(largest principal strain of block) > 4 %: free start\n", ""
        )
    )
    (tmp_path / "data.csv").write_text(f"t,s\n0,0\n0.05,{0.8 * peak[1]}\n")
    request = Request.file(path)
    compiled, _ = compile_request(request)
    learned = learn(compiled, compiled.fit_problems[0], request)
    (estimate,) = learned.estimates
    assert estimate.value[0] == pytest.approx(8e3, rel=1e-3)


OF_ELEMENTS = (
    "volume(block)", "stress(block)", "strain(block)", "average(stress tensor of block)",
    "average(largest principal stress of block)", "stress(block at (1, 2, 3) mm)",
    "position(block at (1, 2, 3) mm)", "percentile(von Mises stress of block, 95 %)",
)  # fmt: skip


@every("measure", OF_ELEMENTS)
def test_a_measure_of_elements_has_the_same_bits_however_many_states_there_are(measure):
    """Logs of resumed runs, which take other states at once, are equal to the last bit."""
    scene = tissuec.compile(
        "language 1\n"
        "tissue gel { Young's modulus = 10 kPa; Poisson's ratio = 0.3; density = 1 g/cm^3 }\n"
        "body block {\n"
        "  mesh is lattice { cell = 2 mm; box from (0, 0, 0) mm to (12, 8, 8) mm }\n"
        "  tissue is gel\n}\n"
        "environment { gravity = (0, 0, 0) m/s^2 }\nsimulate { duration = 1 ms }\n"
        f"output {{ {measure} every 1 ms }}\n"
    )
    (log,) = scene.plan.output.logs
    state = State.start(scene.network, gravity=np.zeros(3), drag=0.0)
    moved = 1e-4 * np.random.default_rng(1).standard_normal((5, *state.position.shape))
    none = np.zeros(scene.network.spring_count, dtype=bool)
    batch = Snapshot(state, np.arange(5.0), state.position + moved, moved, none, None)
    rows = log.measure.sample(log.subjects, batch)
    for number in range(5):
        single = log.measure.sample(log.subjects, batch.pick(number))
        assert np.array_equal(single, rows[number])
    for some in ([2], [1, 3]):
        found = log.measure.sample(log.subjects, batch.pick(np.array(some)))
        assert np.array_equal(found, rows[some])
