"""Whole runs of solids and walls that are cut: by SciPy, resumed, and on threads."""

import pytest

from tests.cuts import test_divided_solids as solids
from tests.cuts import test_divided_walls as walls
from tests.validate.scenes import compiled_scene, same_motion
from tests.whole_runs import same_on_two_threads, same_when_resumed


class Quadratic:
    """Solids of hexahedra with 27 nodes."""

    @staticmethod
    def slit(mesh="lattice { cell = (10, 5, 5) mm; box from (0, 0, 0) mm to (20, 10, 5) mm }"):
        return solids.slit(mesh + solids.OF_27_NODES)


both = pytest.mark.parametrize("body", [solids, walls], ids=["solid", "wall"])
each = pytest.mark.parametrize(
    "body", [solids, walls, Quadratic], ids=["solid", "wall", "quadratic"]
)
DENSE = {
    Quadratic: "lattice { cell = 2.5 mm; box from (0, 0, 0) mm to (20, 10, 5) mm }",
    solids: "lattice { cell = 1.25 mm; box from (0, 0, 0) mm to (20, 10, 5) mm }",
    walls: walls.FINE,
}


@each
def test_scipy_finds_the_same_motion(body):
    same_motion(body.slit())


@both
def test_scipy_finds_the_same_motion_of_relaxing_parts(body):
    relaxing = "relaxing share = 30 %; relaxation time = 5 ms\n  retardation time"
    same_motion(body.slit().replace("retardation time", relaxing))


@each
def test_a_run_that_is_resumed_within_a_cut_gives_the_same_bytes(body):
    _, *parts = same_when_resumed(compiled_scene(body.slit()), "force of base", 3, 6)
    assert any(first.state.blades for first, _ in parts)


@each
def test_threads_change_no_bit(threads_in_small_nets, body):
    text = body.slit(DENSE[body]).replace("10 ms", "4 ms")
    same_on_two_threads(compiled_scene(text), "force of base")
