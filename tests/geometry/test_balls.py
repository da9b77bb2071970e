"""Points in balls, against looking at every pair."""

import numpy as np
import pytest

from tissuec.geometry import neighbours
from tissuec.geometry.neighbours import are_between, in_balls


def found(middle, radius, points):
    """Return the pairs of ball and point, and those that all distances tell."""
    pairs = set(zip(*(each.tolist() for each in in_balls(middle, radius, points)), strict=True))
    distance = np.linalg.norm(middle[:, None] - points, axis=2)
    return pairs, set(map(tuple, np.argwhere(distance <= radius[:, None]).tolist()))


@pytest.mark.parametrize("few", [0, neighbours.FEW], ids=["trees", "an axis"])
@pytest.mark.parametrize("spread", [0.0, 3.0])
def test_pairs_are_those_of_all_distances(spread, few, monkeypatch):
    """Also of balls whose sizes differ a thousandfold, by trees or along an axis."""
    monkeypatch.setattr(neighbours, "FEW", few)
    random = np.random.default_rng(4)
    middle, points = random.uniform(0.0, 1.0, (200, 3)), random.uniform(0.5, 2.0, (300, 3))
    radius = 0.8 * 10.0 ** -random.uniform(0.0, spread, 200) if spread else np.full(200, 0.2)
    pairs, expected = found(middle, radius, points)
    assert len(expected) > 20 and pairs == expected
    assert len(in_balls(middle, radius, points)[0]) == len(expected)


@pytest.mark.parametrize("few", [-1, neighbours.FEW], ids=["trees", "an axis"])
@pytest.mark.parametrize(("count", "points"), [(0, 5), (5, 0), (0, 0), (5, 5)])
def test_far_away_or_without_any_there_are_no_pairs(count, points, few, monkeypatch):
    monkeypatch.setattr(neighbours, "FEW", few)
    pairs, expected = found(np.zeros((count, 3)), np.ones(count), np.full((points, 3), 7.0))
    assert pairs == expected == set()


def test_a_box_has_its_own_surface():
    low, high = np.zeros(3), np.ones(3)
    points = np.array([[0.0, 1.0, 0.5], [1.0, 1.0, 1.1], [-1e-9, 0.5, 0.5]])
    assert are_between(points, low, high).tolist() == [True, False, False]
