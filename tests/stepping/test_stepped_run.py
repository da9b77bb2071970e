"""Stepping from Python gives the motion of a run to the last bit, whatever comes between."""

import pickle
import random

import numpy as np
import pytest

import tissuec
from tests.engine.execution.test_turned_elements import BAR
from tissuec.core.errors import CompileError, TissueError
from tissuec.engine.integrators import INTEGRATORS

ROPE = """language 1
param lift = 3 mm between 0 mm and 10 mm
tissue gut {{ spring constant = 2 N/m; viscosity = 1 mN*s/m; breaking force = {strength} }}
body rope {{ mesh is explicit; tissue is gut; rupture is allowed }}
table nodes of rope in mm with columns "id x mass in g" {{
  1 0 4
  2 12 4
  3 20 4
  4 31 4
}}
table springs of rope with columns "a b rest length in mm" {{
  1 2 10
  2 3 10
  3 4 10
}}
set wall = nodes of rope where id == 1
set middle = nodes of rope where id == 2
set tip = nodes of rope where id == 4
tool tongs {{ kind is forceps }}
environment {{ gravity = (0, 0, -1) m/s^2; contact is off; damping = 0 N*s/m }}
script {{
  at 0 s: fix wall
  from 0.05 s to 0.2 s: push tip with (4, 0, 0) mN using smooth profile
  when position(tip along (1, 0, 0)) > 34 mm: change viscosity of rope by 3
}}
simulate {{ duration = 0.5 s; {method} }}
output {{ trajectory every 20 ms; position of tip every 1 ms; energy every 7 ms }}
expect position(tip) < 1 m over run
"""
STEPS = "step = 1 ms; integrator is "


def rope(*, strength="1 kN", method="tolerance = 1e-5"):
    return ROPE.format(strength=strength, method=method)


def assert_same(sim, scene):
    """Compare a run that was stepped to its end with one of a scene."""
    result = tissuec.run(scene, companion="off")
    rows = result.logs["position of tip"]
    time, value = sim.log("position of tip")
    assert np.array_equal(time, rows.time)
    assert np.array_equal(value, rows.value)
    assert np.array_equal(sim.position[sim.nodes_of("tip")].mean(axis=0), value[-1])
    mine = [(event.time, event.kind, event.springs) for event in sim.events]
    assert mine == [(event.time, event.kind, event.springs) for event in result.events]


METHODS = [
    "tolerance = 1e-5",
    *(
        (STEPS if method.promises is False else "tolerance = 1e-5; integrator is ") + name
        for name, method in INTEGRATORS.items()
        if not method.conservative
    ),
    "step = 25 ms; integrator is relaxation",
]


@pytest.mark.parametrize(
    ("method", "strength"),
    [
        *((method, "1 kN") for method in METHODS),
        *((method, "6 mN") for method in METHODS if "relaxation" not in method),
    ],
)
@pytest.mark.parametrize("count", [100, pytest.param(1000, marks=pytest.mark.slow)])
def test_many_steps_are_a_run(method, strength, count):
    if "relaxation" in method:  # each of whose steps takes long
        count //= 5
    scene = rope(method=method, strength=strength).replace("every 1 ms", f"every {1 / count} s")
    try:
        tissuec.compile(scene)
    except CompileError as refused:
        pytest.skip(str(refused).splitlines()[0])
    sim = tissuec.start(scene)
    for _ in range(count):
        sim.step(0.5 / count)
    assert sim.time == 0.5
    assert_same(sim, scene)


def test_what_is_ordered_becomes_a_script_which_runs_the_same():
    sim = tissuec.start(rope())
    sim.grasp("tip", with_="tongs")
    sim.step("31.7 ms")
    sim.move("tongs", by=(0.001, 0, 0.002), over="40 ms")
    sim.step(0.05)
    sim.release("tongs")
    sim.change("viscosity", of="rope", by=0.5)
    sim.order("push middle with (0, 2, 0) mN on each node", over=0.1)
    sim.push("tip", with_=0.003, along=(0, 1, 0))
    sim.run_until("0.3 s")
    sim.stop("pushing tip")
    sim.cut("rope", along="plane", through=(0.025, 0, 0), facing=(1, 0, 0))
    sim.change("gravity", to=(0, 0, -2))
    sim.hold("tip", over="20 ms")
    sim.step(1.0)
    assert sim.time == 0.5
    assert "  at 0.0 s: grasp tip with tongs\n" in sim.script()
    moved = "move tongs by (0.001, 0, 0.002) m using constant speed"
    assert f"  from 0.0317 s to 0.0717 s: {moved}\n" in sim.script()
    assert_same(sim, sim.script())


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (0, 2, 3, 4, 5))]
)
def test_saving_restoring_and_forking_on_the_way_change_nothing(seed):
    draw, sim = random.Random(seed), tissuec.start(rope(strength="8 mN"))
    orders = [
        lambda: sim.push("tip", with_=(draw.uniform(-1, 1) * 4e-3, 0, 1e-3), over="30 ms"),
        lambda: sim.change("viscosity", of="rope", by=draw.uniform(0.5, 2)),
        lambda: sim.change("breaking force", of="rope", to=draw.uniform(5e-3, 20e-3)),
        lambda: sim.move("middle", by=(0, draw.uniform(-1, 1) * 1e-3, 0), over="15 ms"),
        lambda: sim.release("middle") if len(sim.snapshot.state.holders) > 2 else None,
        lambda: sim.settle("tip") if draw.random() < 0.2 else None,
    ]
    saved = [sim.save()]
    while not sim.ended:
        sim.step(draw.choice([1e-4, 1e-3, 0.01, 0.05]))
        if not sim.ended and draw.random() < 0.3:
            for _ in range(draw.randint(1, 2)):
                draw.choice(orders)()
        match draw.randrange(6):
            case 0:
                saved.append(sim.save())
            case 1:
                sim = sim.fork()
            case 2 if draw.random() < 0.3:
                sim.restore(draw.choice(saved))
            case 3 if draw.random() < 0.3:
                sim.restore(pickle.loads(pickle.dumps(draw.choice(saved))))
            case _:
                sim.position  # noqa: B018
    assert_same(sim, sim.script())


def test_two_forks_go_their_own_ways():
    sim = tissuec.start(rope())
    sim.step("0.1 s")
    other = sim.fork()
    other.push("tip", with_=(0, 0, 0.1))
    for one in (sim, other):
        one.step("0.1 s")
    assert sim.measure("position(tip along (0, 0, 1))") < 0.0
    assert other.measure("position(tip along (0, 0, 1))") > 0.0
    assert "push tip with (0, 0, 0.1)" not in sim.script()
    sim.run_until(0.5)
    assert_same(sim, rope())


def test_what_is_seen_belongs_to_the_present_time():
    sim = tissuec.start(rope())
    sim.step("123.4 ms")
    time, rows = sim.log("position of tip")
    assert time[-1] == 0.123
    later = sim.fork()
    later.run_until(0.124)
    assert sim.position[3] == pytest.approx(
        rows[-1] + 0.4 * (later.position[3] - rows[-1]),
        abs=1e-6,  # curved within 1 ms
    )
    x, z = (sim.measure(f"position(tip along {axis})") for axis in ("(1, 0, 0)", "(0, 0, 1)"))
    assert sim.measure("position of tip along (0, 0, 1)") == z  # as studies write it
    assert [x, 0.0, z] == pytest.approx(sim.position[3])
    assert sim.tension.shape == sim.alive.shape == (3,)
    assert sim.force.shape == sim.velocity.shape == (4, 3)
    with pytest.raises(ValueError, match="read-only"):
        sim.position[0] = 0.0


def test_a_result_is_written_as_a_run_writes_it(tmp_path):
    with tissuec.start(rope(), out=tmp_path / "new" / "by_hand.h5", lift="4 mm") as sim:
        sim.step("0.1 s")
        sim.push("tip", with_="10 mN", along=(0, 1, 0))
        sim.step("0.15 s")
        tip = sim.position[3]
    result = tissuec.load(tmp_path / "new" / "by_hand.h5")
    assert result.events[-1].kind == "end the run"
    assert result.events[-1].time == 0.25
    assert result.times[-1] == 0.25
    assert result.logs["position of tip"].value[-1] == pytest.approx(tip, abs=1e-8)
    assert result.promise.state == "kept"


def test_orders_at_times_that_a_rupture_has_set_become_a_script():
    then = "when count(pieces of rope) > 1: { after 10 ms: change viscosity of rope by 3 }"
    first, last = rope(strength="8 mN").split("  when ")
    scene = f"{first}  {then}\n{last.partition(chr(10))[2]}"
    sim = tissuec.start(scene)
    while not any(event.kind == "trigger" for event in sim.events):
        sim.step("1 ms")
    (torn,) = (event.time for event in sim.events if event.kind == "trigger")
    sim.run_until(torn + 0.01)
    sim.push("tip", with_=(0, 1e-3, 0))
    assert {type(event.time) for event in sim.events} == {float}  # as scripts write it
    sim.run_until(0.5)
    assert_same(sim, sim.script())


def test_an_order_comes_before_what_follows_a_trigger_at_the_same_time():
    when = "when position(tip along (1, 0, 0)) > 1 mm: { after 100 ms: "
    change = "change viscosity of rope by 3"
    former = f"when position(tip along (1, 0, 0)) > 34 mm: {change}"
    scene = rope().replace(former, f"{when}{change} }}")
    sim = tissuec.start(scene)
    sim.run_until(0.1)
    sim.order("change viscosity of rope to 1 mN*s/m")
    sim.run_until(0.5)
    changes = [event.cause for event in sim.events if event.kind == "change"]
    assert changes == ["change viscosity of rope to 1 mN*s/m", change]
    assert_same(sim, sim.script())


def test_without_a_file_nothing_is_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with tissuec.start(rope()) as sim:
        sim.step("1 ms")
    assert not list(tmp_path.iterdir())


def test_a_scene_without_a_script_gets_one():
    text = rope()
    start, end = text.index("script {"), text.index("simulate {")
    sim = tissuec.start(text[:start] + text[end:])
    sim.fix("wall")
    sim.run_until("0.5 s")
    assert_same(sim, sim.script())


def test_orders_that_are_wrong_say_where_and_leave_the_run_as_it_is():
    sim = tissuec.start(rope())
    sim.step("10 ms")
    with pytest.raises(CompileError, match=r'no set called "tipp"'):
        sim.push("tipp", with_=(0, 0, 1))
    with pytest.raises(CompileError, match=r"has no unit"):
        sim.order("push tip with (0, 0, 1)")
    with pytest.raises(CompileError, match='"leap" is not a verb'):
        sim.order("leap")
    with pytest.raises(ValueError, match="not a text"):
        sim.push("tip", with_=(0, 0))
    with pytest.raises(ValueError, match="finite number, not nan"):
        sim.push("tip", with_=(0, 0, np.nan))
    with pytest.raises(AttributeError, match='no "leap"'):
        sim.leap("tip")
    with pytest.raises(CompileError, match="is not a measure"):
        sim.measure("weight(tip)")
    with pytest.raises(KeyError, match="the logs are: position of tip"):
        sim.log("force of tip")
    with pytest.raises(ValueError, match="longer"):
        sim.step(0.0)
    with pytest.raises(ValueError, match="cannot step back"):
        sim.run_until("5 ms")
    with pytest.raises(CompileError, match="the time must be"):
        sim.step("3 mm")
    sim.run_until(0.5)
    with pytest.raises(ValueError, match=r"the run has ended; done: 0\.5 s"):
        sim.step("1 ms")
    with pytest.raises(ValueError, match="the run has ended"):
        sim.settle()
    assert_same(sim, rope())


def test_what_is_no_time_and_no_state_is_refused():
    sim = tissuec.start(rope())
    with pytest.raises(ValueError, match="a time in seconds must be a number, not nan"):
        sim.step(float("nan"))
    with pytest.raises(TypeError, match="restore takes what save returned, not NoneType"):
        sim.restore(None)


def test_a_state_belongs_to_a_scene_and_its_values():
    saved = tissuec.start(rope(), lift="2 mm")
    saved.step("20 ms")
    state = pickle.loads(pickle.dumps(saved.save()))
    same = tissuec.start(rope(), lift="2 mm")
    same.restore(state)
    assert np.array_equal(same.position, saved.position)
    other = (
        "by a run of .* with lift = 2 mm, and this is a run of .* with lift = 8 mm; restore it"
    )
    for sim, said in (
        (tissuec.start(rope(), lift="8 mm"), other),
        (tissuec.start(rope().replace("4 31 4", "4 32 4"), lift="2 mm"), "the state was saved"),
        (tissuec.start(rope().replace("(4, 0, 0) mN", "(5, 0, 0) mN")), "the state was saved"),
    ):
        before = sim.position.copy()
        with pytest.raises(TissueError, match=said):
            sim.restore(state)
        assert sim.time == 0.0 and np.array_equal(sim.position, before)


@pytest.mark.parametrize("more", ["at 0 s: free wall", "at 0.4 s: free wall", "free wall"])
def test_one_sentence_is_ordered_at_once(more):
    """Further ones would have times of their own, also in the past."""
    sim = tissuec.start(rope())
    sim.step("20 ms")
    before = sim.script()
    with pytest.raises(CompileError):
        sim.order(f"free tip\n {more}")
    with pytest.raises(CompileError):
        sim.order(f"at 0 s: {more}")
    assert sim.script() == before
    sim.step("1 ms")
    assert not [event for event in sim.events if "free" in event.cause]
    with pytest.raises(ValueError, match="threads must be 1 or more"):
        tissuec.start(rope(), threads=0)


def test_a_run_that_cannot_go_on_says_so_and_can_be_restored():
    sim = tissuec.start(rope())
    sim.step("10 ms")
    saved = sim.save()
    sim.free("wall")
    sim.settle()
    with pytest.raises(tissuec.SimulationError, match="there is no equilibrium"):
        sim.step("1 ms")
    assert "no equilibrium" in sim.ended
    sim.restore(saved)
    sim.run_until("0.5 s")
    assert_same(sim, rope())


def test_values_that_were_given_are_in_the_recorded_script():
    scene = rope().replace("push tip with (4, 0, 0) mN", "push tip with (lift * 1 N/m, 0, 0)")
    given = {
        "lift": 5e-3,  # a param
        "viscosity of gut": "4 mN*s/m",  # an entry
        "mass of rope": "20 g",  # a new one, in a block of one line
        "step": "1 ms",  # in the place of the tolerance
        "integrator": "velocity verlet",
    }
    sim = tissuec.start(scene, params=given)
    sim.run_until(0.3)
    text = sim.script()
    assert "param lift = 0.005 m between" in text
    assert "viscosity = 4 mN*s/m; breaking" in text
    assert "tolerance" not in text and "--set" not in text
    sim.push("tip", with_=(0, 0, 1e-3), over="20 ms")
    sim.run_until(0.5)
    assert_same(sim, sim.script())


def test_values_of_other_files_stand_in_a_comment_of_the_recorded_script(tmp_path):
    tissue = (
        "tissue gut { spring constant = 2 N/m; viscosity = 1 mN*s/m; breaking force = 1 N }"
    )
    (tmp_path / "gut.tis").write_text(f"language 1\n{tissue}\n")
    lines = rope().split("\n")
    (tmp_path / "rope.tis").write_text("\n".join([lines[0], 'use "./gut"', *lines[3:]]))
    sim = tissuec.start(tmp_path / "rope.tis", params={"viscosity of gut": "3 mN*s/m"})
    sim.push("tip", with_=(0, 0, 1e-3))
    assert sim.script().endswith('# Run with: --set "viscosity of gut = 3 mN*s/m"\n')


def test_measures_are_written_as_in_conditions_and_in_studies():
    sim = tissuec.start(rope())
    sim.step("60 ms")
    assert sim.measure("position of tip along (1, 0, 0)") == sim.position[3, 0]
    assert sim.measure("position of tip") == pytest.approx(np.linalg.norm(sim.position[3]))
    assert sim.measure("force of tip") == sim.measure("force(tip)")
    assert abs(sim.measure("energy drift")) < 1e-3
    other = sim.fork()
    other.step("10 ms")
    assert other.measure("position of tip along (1, 0, 0)") == other.position[3, 0]


@pytest.mark.parametrize(
    ("what", "message"),
    [
        ("2 mm", "measures nothing"),
        ("energy", '"energy" does not say what it is measured on'),
        ("position(tip, 10 ms)", "cannot name a time"),
        ("position of tipp", 'no set, body or tool called "tipp"'),
        ("position(tip) of wall", r"for example: force\(A\)"),
    ],
)
def test_what_measures_nothing_now_is_refused(what, message):
    with pytest.raises(CompileError, match=message):
        tissuec.start(rope()).measure(what)


def test_the_present_time_is_held_where_the_method_changes_on_the_way():
    """A change of the integrator, here after some steps, keeps what the run is to stop at."""
    text = BAR.replace("ANGLE", "480")
    sim = tissuec.start(text)
    for time in (0.25, 0.5):
        sim.run_until(f"{time} s")
        assert sim.time == time
    changes = tissuec.run(text, companion="off").manifest["statistics"]["changes"]
    assert len(changes) > 1


def test_several_values_are_no_measure():
    with pytest.raises(ValueError, match="not one value but 2"):
        tissuec.start(rope()).measure("force(tip); b = 3")


def test_energies_that_are_not_kept_cannot_be_measured():
    sim = tissuec.start(rope().replace("; energy every 7 ms", ""))
    with pytest.raises(CompileError, match="does not keep the energies"):
        sim.measure("energy drift")


def test_the_present_net_is_a_mesh_of_pyvista():
    pytest.importorskip("pyvista")
    sim = tissuec.start(rope(strength="6 mN"))
    sim.run_until("0.3 s")
    mesh = sim.to_pyvista()
    assert not sim.alive.all()  # what is torn is not drawn
    assert np.array_equal(mesh.points, sim.position)
    lines = mesh.celltypes == 3
    assert np.array_equal(mesh.cells_dict[3], sim.network.springs.ends[sim.alive])
    assert np.array_equal(mesh.cell_data["spring_force"][lines], sim.tension[sim.alive])
    assert mesh.field_data["TimeValue"] == [0.3]
