"""Whole runs of solid elements against an independent library, and against themselves."""

import json
from pathlib import Path

import numpy as np
import pytest

import tissuec
from tests.forces.solid_cases import CASES, answers, lattice, text_of
from tissuec.core.structs import replace
from tissuec.mechanics import newton

KNOWN = json.loads(
    (Path(__file__).parent / "solid_references.json").read_text(encoding="utf-8")
)
#: Cells across, and by how much answers may differ from those of ever smaller elements. The
#: edges of the held face are singular: under its own weight, a cube of 2 x 2 x 2 hexahedra of
#: 27 nodes of the library, with as many nodes as 4 x 4 x 4 of tissuec, sinks in by 4.9 % less.
LEAN = [("own weight", "hexahedra", 4, 0.021), ("cantilever", "hexahedra", 2, 0.011),
        ("torsion", "hexahedra", 4, 0.04)]  # fmt: skip
FULL = [("cube, ν = 0.3", "hexahedra", 4, 0.017), ("cantilever", "hexahedra", 4, 0.004),
        ("torsion", "hexahedra", 6, 0.02), ("cube, ν = 0.3", "tetrahedra", 2, 0.02),
        ("cantilever", "tetrahedra", 2, 0.01)]  # fmt: skip


def compared(name, shape, cells, bound, folder):
    found = answers(CASES[name], shape, cells, folder)
    errors = [found[shown] / due - 1.0 for shown, due in KNOWN[name].items()]
    assert len(found) >= len(errors) > 0
    assert max(map(abs, errors)) < bound, errors


@pytest.mark.parametrize(("name", "shape", "cells", "bound"), LEAN)
def test_few_elements_give_what_many_of_another_library_give(
    name, shape, cells, bound, tmp_path
):
    compared(name, shape, cells, bound, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "shape", "cells", "bound"), FULL)
def test_more_elements_give_it_more_closely(name, shape, cells, bound, tmp_path):
    compared(name, shape, cells, bound, tmp_path)


NEAR = "from (0, 0, 0) mm to (20, 20, 20) mm"
FAR = "from (3000, 4000, 5000) mm to (3020, 4020, 5020) mm"


def there_and_back(poisson, cells, step, depth):
    """Return a scene of a cube that is pressed by steps [mm], drawn back and released."""
    down = (step,) * round(depth / step)
    case = replace(CASES["cube, ν = 0.3"], poisson=poisson)
    text = text_of(case, lattice(case, cells), (*down, *(-one for one in down)))
    last = 4 * len(down)
    return (
        text.replace("--", "")
        .replace("\n}\nsimulate", f"\n  at {last} us: {{ release far; settle }}\n}}\nsimulate")
        .replace(f"duration = {last} us", f"duration = {last + 2} us")
    )


def returns(poisson, cells, step, depth):
    with tissuec.run(there_and_back(poisson, cells, step, depth), companion="off") as run:
        assert run.finished
        moved = np.abs(run.position[:] - run.position[0]).max(axis=(1, 2))
    assert moved.max() >= 1e-3 * depth * (1.0 - 1e-12)
    assert moved[-1] < 1e-6 * moved.max()


def test_a_block_that_was_pressed_returns_to_its_shape():
    returns(0.49, 2, 2.0, 8.0)


@pytest.mark.slow
@pytest.mark.parametrize("poisson", [0.3, 0.49])
def test_a_finer_block_that_was_pressed_to_half_its_height_returns(poisson):
    returns(poisson, 4, 1.0, 10.0)


@pytest.mark.parametrize(("step", "drawn"), [(1.0, NEAR), (0.01, FAR)], ids=["", "far"])
def test_newtons_method_ends_with_the_exact_matrix(step, drawn, monkeypatch):
    """Without loads or springs, forces are judged by those of elements at held nodes.

    Far from the origin, places have fewer digits behind the point.
    """
    exacts, own = [], newton.tangent_at

    def counted(*arguments, matrices: tuple[bool, ...]):
        exacts.append(matrices[0])
        return own(*arguments, matrices=matrices)

    monkeypatch.setattr(newton, "tangent_at", counted)
    case = CASES["cube, ν = 0.3"]
    text = text_of(case, lattice(case, 2), (step,)).replace(NEAR, drawn)
    if drawn == FAR:
        text = text.replace("where z", "where z - 5000 mm")
    with tissuec.run(text, companion="off") as run:
        assert run.finished
    assert len(exacts) <= 10
    assert exacts and all(exacts[-2:])
