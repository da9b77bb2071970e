"""Thin tools that are pulled into solids: none passes, however soft contact is."""

import numpy as np
import pytest

from tests.contact.scenes import play
from tests.contact.test_pulls import PASSES, drawn_above, moved, passes

BLOCK = """language 1
tissue gel {{ Young's modulus = 20 kPa; Poisson's ratio = 0.3; density = 1000 kg/m^3
  retardation time = 5 ms }}
body block {{ mesh is lattice {{ cell = 4 mm; box from (-10, -10, -8) mm to (10, 10, 0) mm }}
  tissue is gel }}
set base = nodes of block where z < -7.9 mm
{tool}
environment {{
  gravity = (0, 0, 0) m/s^2; mass damping = 100 Hz; contact is tools only
  contact surface stiffness = {stiffness:.4g} MPa/m
}}
script {{
  at 0 s: fix base
  {script}
}}
simulate {{ duration = 20 ms; tolerance = 1e-2 }}
output {{ force of tool every 1 ms; trajectory every 0.2 ms }}
"""


def pull(number):
    """Return a random scene: a needle or a hook above a block, and where it goes."""
    chance = np.random.default_rng([21, number])
    tool, lowest = drawn_above(chance, 0.2)
    down = -chance.uniform(0.5, 3.0) - lowest
    return BLOCK.format(
        tool=tool,
        stiffness=10.0 ** chance.uniform(0.0, 3.0),
        script=moved("tool", [*chance.uniform(-6.0, 6.0, 2), down]),
    )


def held(numbers):
    """Check that pulls are held, and return how many of them sink in deep."""
    deep = 0
    for number in numbers:
        played = play(pull(number))
        doubts = [one for one in played.outcome.doubts if one.kind == PASSES]
        force = np.linalg.norm(played.log("force of tool")[1], axis=1)
        assert played.outcome.kind == "done"
        assert not any("holds it no longer" in one.what for one in doubts), number
        # A tool that has passed bears nothing; nor does one that slides off the block.
        assert force[-1] > 0.5 * force.max() > 0.0 or not passes(played), number
        deep += bool(doubts)
    return deep


def test_no_thin_tool_passes_a_block():
    assert 0 < held(range(6)) < 6


@pytest.mark.slow
def test_no_thin_tool_of_a_hundred_passes_a_block():
    assert 0 < held(range(6, 100)) < 50
