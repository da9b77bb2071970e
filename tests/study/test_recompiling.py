"""Programs that are compiled again with other values give what a first compilation gives."""

import random

import numpy as np
import pytest

from tests.study.scenes import WORDS
from tissuec.compiler.recompiling import Recompiler
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.scene.program.imports import load
from tissuec.scene.reading.findings import Findings

SCENE = """language 1
use "fuzzy/soft_tissue"
param lift = 2 mm between 0 mm and 20 mm
param height = 4 mm
param wide = 3 mm
param softness = 1
let stiffness = 2 N/m / softness
tissue skin {
  WORDS
}
tissue scar like skin { spring constant = stiffness }
body strip {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (10, 0, 0) mm; second edge = (0 mm, height, 0 mm)
    columns = 5; rows = 3; diagonals is both
  }
  tissue is skin
  region wound where x < wide { tissue is scar }
  interface is mean
}
body bar { mesh is explicit; tissue is scar }
table nodes of bar in mm with columns "id x y mass in g" { 1 0 20 1; 2 10 20 1 }
table springs of bar with columns "a b" { 1 2 }
set left = nodes of strip where x < wide - 1 mm
set right = nodes of strip where x > 9 mm
tool hand { kind is forceps }
environment { gravity = (0, 0, 0) m/s^2; contact is off }
script {
  at 0 s: { fix left; grasp right with hand }
  from 0 s to 0.1 s: move hand by (lift, 0, 0) using ramp
}
simulate { duration = 0.2 s; tolerance = 1e-4 }
output { trajectory every 10 ms }
""".replace("WORDS", WORDS)
VALUES = [
    ("lift = 3 mm", "lift = 4 mm"),
    ("height = 4 mm", "height = 5 mm"),
    ("wide = 3 mm", "wide = 6 mm"),
    ("softness = 1", "softness = 2"),
    ("hardness of skin is hard", "hardness of skin is slightly hard"),
    ("tissue of bar is skin", "mass of strip = 3 g"),
    ("columns of strip = 4", "columns of strip = 7"),
    ("tolerance = 1e-5", "integrator is velocity verlet"),
]
KEPT = {"lift", "tolerance", "integrator"}  # which nothing of a body follows from
ARRAYS = ("position", "velocity", "mass", "stiffness", "damping", "rest", "ends", "skin")


def recompiler():
    return Recompiler(load(Source("strip.tis", SCENE), (), Findings()))


def assert_same(found, known):
    for name in ARRAYS:
        one, other = found.network.array(name), known.network.array(name)
        assert np.array_equal(one, other), name
    assert str(found.plan.simulation) == str(known.plan.simulation)
    assert repr(found.plan.events) == repr(known.plan.events)


@pytest.mark.parametrize("seed", range(3))
def test_any_values_in_any_order_give_what_a_first_compilation_gives(seed):
    draw, again = random.Random(seed), recompiler()
    for _ in range(15):
        chosen = draw.sample(VALUES, draw.randint(0, 3))
        overrides = [draw.choice(pair) for pair in chosen]
        found = again.compile(overrides, Findings())
        assert_same(found, recompiler().compile(overrides, Findings()))


@pytest.mark.parametrize("pair", VALUES, ids=lambda pair: pair[0].split(" ")[0])
def test_bodies_are_built_again_where_values_change_them(pair):
    again = recompiler()
    first, second = (again.compile([value], Findings()) for value in pair)
    kept = first.network.springs.ends is second.network.springs.ends
    assert kept == (pair[0].split(" ")[0] in KEPT)


def test_mistakes_are_told_each_time_and_leave_nothing_behind():
    again = recompiler()
    known = again.compile([], Findings())
    for overrides, message in (
        (["lift = 30 mm"], "not between"),
        (["columns of strip = 0"], "columns"),
        (["columns of strip = 0"], "columns"),
        (["height = 0 mm"], "edge"),
    ):
        with pytest.raises(CompileError, match=message):
            again.compile(overrides, Findings())
    assert_same(again.compile([], Findings()), known)
