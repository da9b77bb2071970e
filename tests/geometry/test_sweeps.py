"""Segments that pass through triangles while both move: against many states in between."""

import numpy as np
import pytest

from tissuec.geometry.sweeps import Passage, SweptSurface, near, side_of, sweeps, through

PIECES, TRIANGLE = np.array([[0, 1]]), np.array([[2, 3, 4]])


def crosses(position):
    """Return whether the segment goes through the triangle, by a system of equations."""
    start, end, a, b, c = position
    s, u, v = np.linalg.solve(np.stack([start - end, b - a, c - a], axis=1), start - a)
    return 0.0 < s < 1.0 and min(u, v, 1.0 - u - v) > 0.0


def found_between(before, now):
    surface = SweptSurface.of(TRIANGLE)
    pairs = near(before, now, PIECES, TRIANGLE)
    return sweeps(before, now, PIECES, surface, pairs)


def test_crossings_begin_and_end_at_the_passages_that_are_found():
    random = np.random.default_rng(5)
    begun = ended = between = 0
    for _ in range(100):
        before, way = random.normal(size=(5, 3)), random.normal(size=(5, 3))
        shares = np.linspace(0.0, 1.0, 401)
        states = [crosses(before + share * way) for share in shares]
        changes = np.flatnonzero(np.diff(np.array(states, dtype=int)))
        # One sign change in each volume: the ways are as short as that.
        for start, stop in zip(shares[changes], shares[changes + 1], strict=True):
            first, last = before + start * way, before + stop * way
            passages = found_between(first, last)
            assert len(passages) == 1
            place = first[0] + passages[0].share * (first[1] - first[0])
            assert 0.0 <= passages[0].share <= 1.0 and np.isfinite(place).all()
            begun, ended = begun + (not crosses(first)), ended + crosses(first)
        if len(changes) == 0 and not states[0]:
            between += len(found_between(before, before + 0.1 * way))
    assert min(begun, ended) > 15 and between == 0


@pytest.mark.parametrize("shift", [np.zeros(3), np.array([3.0, -2.0, 5.0])])
def test_a_segment_that_passes_as_a_whole_passes_with_both_ends_or_past_edges(shift):
    triangle = np.array([[-1.0, -1.0, 0.0], [3.0, -1.0, 0.0], [-1.0, 3.0, 0.0]])
    short = np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.3]])
    long_ = np.array([[-5.0, 0.21, 0.3], [5.0, 0.22, 0.3]])
    for segment, shares in ((short, [0.0, 1.0]), (long_, [0.4, 0.678])):
        before = np.concatenate([segment, triangle])
        # Both move, in opposite directions.
        now = before + shift + np.concatenate([[[0, 0, -0.4]] * 2, [[0, 0, 0.3]] * 3])
        found = sorted(found_between(before, now), key=lambda one: one.share)
        assert [one.share for one in found] == pytest.approx(shares, abs=1e-2)
        assert not through(now, PIECES, TRIANGLE, np.array([[0, 0]]))
        assert not found_between(before, before + shift)


def test_a_ball_passes_through_an_edge_of_two_triangles_at_least_once():
    quad = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])
    for place in np.linspace(-0.9, 0.9, 37):
        before = np.concatenate([[[place, place, 0.1]], quad])
        now = before.copy()
        now[0] = [place + 0.01, place + 0.01, -0.1]
        triangles = np.array([[1, 2, 3], [1, 3, 4]])
        pieces = np.array([[0, 0]])
        pairs = near(before, now, pieces, triangles)
        assert sweeps(before, now, pieces, SweptSurface.of(triangles), pairs)


def test_the_place_of_a_crossing_and_its_side():
    position = np.array(
        [[0.2, 0.2, 0.3], [0.2, 0.2, -0.1], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]
    )
    (one,) = through(position, PIECES, TRIANGLE, np.array([[0, 0]]))
    assert one == Passage(0, pytest.approx(0.75), 0)
    assert side_of(position[0], position, TRIANGLE) == (True, 2)
    assert side_of(np.array([0.9, 0.05, -0.1]), position, TRIANGLE) == (False, 3)


def test_the_least_oblique_triangle_tells_the_side_at_a_sharp_edge():
    # A wedge along y with its edge at the origin; each face looks outwards.
    position = np.array([[0, -1, 0], [0, 1, 0], [-9, 0, -1], [-9, 0, 1]], dtype=float)
    triangles = np.array([[0, 1, 3], [1, 0, 2]])
    for point, is_outside in (([0.5, 0.0, 0.0], True), ([-5.0, 0.0, 0.0], False)):
        for beside in (0.3, -0.3):
            place = np.add(point, [0.0, 0.0, beside])
            assert side_of(place, position, triangles)[0] == is_outside
