"""The nets of the benchmarks: what they are, and that every method keeps its word on them."""

import pytest

from benchmarks.rivals.offers import RIVALS
from benchmarks.rivals.ratios import LEVELS, ratios
from benchmarks.scenes import NETS, SCENES, Scene
from tissuec.analysis.bench import bench
from tissuec.pipeline import compile_request
from tissuec.script.plan import AUTOMATIC


def compiled(scene):
    found, warnings = compile_request(scene.request())
    assert {one.code for one in warnings} <= {"W413"}  # that a run of extreme nets takes long
    return found


@pytest.mark.parametrize(
    ("scene", "nodes", "springs"),
    [
        (Scene("tube", ("harder=1e4", "thicker=1e4", "knot=1e6")), 160, 544),
        (SCENES["S1"], 160, 610),
        (SCENES["S3"], 160, 610),
        (SCENES["L10"], 1000, 7560),
        (SCENES["L22"], 10_648, 88_704),
        (SCENES["H16"], 4096, 33_120),
        (SCENES["V60"], 3600, 14_042),
        (SCENES["C2000"], 2000, 2001),
    ],
    ids=lambda one: one.net if isinstance(one, Scene) else str(one),
)
def test_nets_have_the_sizes_that_they_are_known_by(scene, nodes, springs):
    network = compiled(scene).network
    assert (network.node_count, network.spring_count) == (nodes, springs)


def test_a_tenth_of_the_springs_of_the_hard_core_are_a_thousand_times_harder():
    stiffness = compiled(SCENES["H16"]).network.springs.stiffness
    hard = stiffness == stiffness.max()
    assert stiffness.max() == pytest.approx(1e3 * stiffness[~hard].max())
    assert hard.mean() == pytest.approx(0.1, abs=0.01)


def test_every_net_is_measured():
    assert {scene.net for scene in SCENES.values()} | {"tube"} == {
        path.stem for path in NETS.glob("*.tis")
    }


@pytest.mark.slow
@pytest.mark.parametrize("overrides", [(), ("thicker=0",)], ids=["damped", "undamped"])
def test_errors_stay_near_tolerances_on_the_tube(overrides):
    found = bench(
        compiled(Scene("tube", overrides)),
        methods=(), tolerances=(1e-2, 1e-3, 1e-4), repeat=1, budget=5.0, tell=print,
        rivals=RIVALS,
    )  # fmt: skip
    assert found.floor < 1e-6
    for point in found.points:
        if point.ours:
            assert point.error < 2.0 * point.tolerance, point.name
    assert ratios(found.points, AUTOMATIC, LEVELS, found.floor)
