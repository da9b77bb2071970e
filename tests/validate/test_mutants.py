"""Faults of one part in a hundred in the engine's forces are found by ``validate``."""

import pytest

from tests.validate.mutants import FORCES, SCENES, found_in, survey, tried

#: A scene of each tier, and faults that it has to tell from the truth.
QUICK = {
    "compiled": (
        "springs",
        {"stiffness[s] * (length - rest[s])", "damping[s] * closing", "tension * r0"},
    ),
    "interpreted": ("memory", {"net.behaviour.pull(e) + inelastic.pull(e, variables)"}),
}


@pytest.mark.parametrize("tier", FORCES)
def test_some_faults_are_found(tier):
    scene, texts = QUICK[tier]
    chosen = {mutant.text: mutant for mutant in found_in(tier, scene) if mutant.text in texts}
    assert set(chosen) == texts
    assert {tried(tier, scene, mutant) for mutant in chosen.values()} == {"broken"}


@pytest.mark.slow
@pytest.mark.parametrize("tier", FORCES)
def test_every_fault_is_found_by_some_scene(tier):
    assert survey(tier, list(SCENES)).left == {}
