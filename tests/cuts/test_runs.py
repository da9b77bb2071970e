"""Whole runs of solids and walls that are cut: by SciPy, resumed, and on threads."""

import pytest

from tests.cuts import test_divided_solids as solids
from tests.cuts import test_divided_walls as walls
from tests.validate.scenes import compiled_scene, same_motion
from tests.whole_runs import same_on_two_threads, same_when_resumed

both = pytest.mark.parametrize("body", [solids, walls], ids=["solid", "wall"])
DENSE = {
    solids: "lattice { cell = 1.25 mm; box from (0, 0, 0) mm to (20, 10, 5) mm }",
    walls: walls.FINE,
}


@both
def test_scipy_finds_the_same_motion(body):
    same_motion(body.slit())


@both
def test_scipy_finds_the_same_motion_of_relaxing_parts(body):
    relaxing = "relaxing share = 30 %; relaxation time = 5 ms\n  retardation time"
    same_motion(body.slit().replace("retardation time", relaxing))


@both
def test_a_run_that_is_resumed_within_a_cut_gives_the_same_bytes(body):
    _, *parts = same_when_resumed(compiled_scene(body.slit()), "force of base", 3, 6)
    assert any(first.state.blades for first, _ in parts)


@both
def test_threads_change_no_bit(threads_in_small_nets, body):
    text = body.slit(DENSE[body]).replace("10 ms", "4 ms")
    same_on_two_threads(compiled_scene(text), "force of base")
