"""Faults of one part in a hundred in the engine's forces are found by ``validate``."""

import os

import pytest

from tests.validate.mutants import SCENES, found_in, survey, tried

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes as on POSIX")

#: Scenes, and faults that they have to tell from the truth.
QUICK = {
    "springs": {
        "stiffness[k] * (length - rest[k])",
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


@pytest.mark.slow
def test_every_fault_is_found_by_some_scene():
    assert survey(list(SCENES)).left == {}
