"""Thin tools that are pulled into solids: none passes, however soft contact is."""

import numpy as np
import pytest

from tests.contact.scenes import play
from tests.contact.test_pulls import PASSES, moved, passes, text_of

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
    radius = chance.uniform(0.2, 1.5)
    points = [np.zeros(3)]
    for _ in range(chance.integers(1, 4)):
        way = chance.standard_normal(3)
        points.append(points[-1] + chance.uniform(3.0, 8.0) * way / np.linalg.norm(way))
    points = np.array(points) - np.mean(points, axis=0)
    points[:, :2] += chance.uniform(-5.0, 5.0, 2)
    points[:, 2] += radius + chance.uniform(0.3, 1.0) - points[:, 2].min()
    drawn = [f"{text_of(point)} mm" for point in points]
    tool = f"tool tool {{ radius = {radius:.4f} mm; "
    if len(points) == 2:
        tool += f"kind is probe; axis from {drawn[0]} to {drawn[1]}"
    else:
        tool += f"kind is hook; shaft from {drawn[0]} to {drawn[1]}; bend = {drawn[2]}"
        tool += f"; tip = {drawn[3]}" if len(points) > 3 else ""
    down = -chance.uniform(0.5, 3.0) - points[:, 2].min()
    return BLOCK.format(
        tool=tool + " }",
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
    assert 0 < held(range(12)) < 12


@pytest.mark.slow
def test_no_thin_tool_of_a_hundred_passes_a_block():
    assert 0 < held(range(12, 100)) < 50
