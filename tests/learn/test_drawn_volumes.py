"""Start positions are learned where volumes are preserved, which follow from them."""

import numpy as np
import pytest

from tests.learn.test_fields import BAG
from tests.learn.test_resting import assert_derived
from tests.learn.trials import adjust, differing, fit, moving, series
from tests.validate.scenes import compiled_scene
from tissuec.core.structs import replace
from tissuec.learn.derivatives.refusals import refusal

INFLATED = "from 0 s to 20 ms: inflate bag to 5 ml using smooth profile"
#: What is needed of positions, which are in the units of this part of the size of the net.
THETA = np.array([0.3, -0.5, 0.2, 0.1])


def bag(script):
    """Return the bag of a script without its inflation, and what is learnt and seen of it."""
    first, last = BAG.index("  from 0 s to 20 ms: inflate"), BAG.index("simulate")
    compiled = compiled_scene(BAG[:first] + script + "}\n" + BAG[last:])
    side = replace(
        adjust("start position", "side", per="set", low=-np.inf),
        members=compiled.nodes_of("side"),
    )
    seen = series(fit(compiled, "position", "top", columns=3), np.array([2e-3, 5e-3]))
    return compiled, [side, adjust("spring constant", "wall")], [seen]


def test_derivatives_are_those_of_the_predictions():
    scene = bag("")
    exact, runs = moving(*scene), differing(*scene)
    assert refusal(exact.shaping) == ""
    assert_derived(exact, THETA)
    expected = runs.predict(THETA)
    assert exact.predict(THETA) == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


def test_positions_change_the_volume_that_is_inflated():
    shaping = differing(*bag(INFLATED)).shaping
    assert refusal(shaping) == "start positions change the volumes that are inflated"
