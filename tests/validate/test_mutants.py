"""Faults of one part in a hundred in the engine's forces are found by ``validate``."""

import os
import re
from importlib import import_module
from pathlib import Path

import pytest

from tests.forces.test_potential_fields import POTENTIALS, example
from tests.validate.mutants import FORCES, SCENES, found_in, functions_of, survey, tried
from tissuec import forces

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes as on POSIX")

#: Scenes, and faults that they have to tell from the truth.
QUICK = {
    "springs": {
        "damping[k] * closing",
        "part * reach[k]",
    },
    "memory": {"internal.constant[k] * (e - q)"},
}


#: The same of the sign of depths, which takes longer.
OF_SIGNS = {
    "touches.radius[pair] + below",
    "turned / size if size > 0.0 else 0.0",
    "touches.radius[pair] - depth",
}


@pytest.mark.parametrize(
    ("scene", "texts"),
    [*QUICK.items(), pytest.param("needle", OF_SIGNS, marks=pytest.mark.slow)],
)
def test_some_faults_are_found(scene, texts):
    chosen = {mutant.text: mutant for mutant in found_in(scene) if mutant.text in texts}
    assert set(chosen) == texts
    assert {tried(scene, mutant) for mutant in chosen.values()} == {"broken"}


#: Kernels without forces: derivatives, limits of what breaks and stresses that they read, and
#: records. Points and bristles of faces are tested against closed forms and the reference in
#: tests/contact: each mutant takes a minute there.
#: Fields of potentials trace functions of others.
NOT_SURVEYED = (
    "derivatives", "limits", "elements", "record", "bristle",
    "potential_fields", "pooled_fields",
)  # fmt: skip
ONLY_MATRICES = ("jets.py",)  # follow from what is traced in these


#: What makes kernels of functions.
TRACES = re.compile(r"\bTraced(Item|Point|Pool)\(")


def test_every_kernel_of_forces_is_surveyed():
    folder = Path(forces.__file__).parent
    kernels = {
        ".".join(("tissuec", "forces", *path.relative_to(folder).with_suffix("").parts))
        for path in folder.rglob("*.py")
        if (path.match("*_kernel.py") or TRACES.search(path.read_text(encoding="utf-8")))
        and not path.stem.removesuffix("_kernel").endswith(NOT_SURVEYED)
        and path.name not in ONLY_MATRICES
    }
    assert {"tissuec.forces.acting.jets_kernel", "tissuec.forces.enclosed.pressure"} <= kernels
    for each in POTENTIALS:
        kernels.add(type(example(each)[0]).__module__)
    assert kernels <= set(FORCES)
    for name, only in FORCES.items():
        found = {function.__name__ for function in functions_of(import_module(name))}
        assert found
        assert set(only or ()) <= found


@pytest.mark.slow
def test_every_fault_is_found_by_some_scene():
    assert survey(list(SCENES)).left == {}
