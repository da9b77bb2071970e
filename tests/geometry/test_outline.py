"""Sheets that cannot pass through themselves: against all of their edges and triangles."""

import numpy as np
import pytest

from tissuec.geometry.edges import Edges
from tissuec.geometry.outline import Outline
from tissuec.geometry.sweeps import crossings

ROWS, COLUMNS = 9, 7
PLACE = np.indices((ROWS, COLUMNS)).reshape(2, -1).T.astype(float)
CORNERS = (np.arange(ROWS - 1)[:, None] * COLUMNS + np.arange(COLUMNS - 1)).ravel()[:, None]
HALVES = np.array([[0, 1, COLUMNS], [1, COLUMNS + 1, COLUMNS]])
SHEET = np.concatenate([CORNERS + half for half in HALVES])
RING = SHEET[~np.isin(SHEET, [30, 31, 32, 38]).any(axis=1)]


def crosses(position, triangles):
    """Return whether an edge goes through a triangle with which it has no node in common."""
    edges = Edges.among(triangles).ends
    pairs = crossings(position[edges], position[triangles])
    shared = (edges[pairs[:, 0]][:, :, None] == triangles[pairs[:, 1]][:, None]).any(
        axis=(1, 2)
    )
    return bool((~shared).any())


def test_sheets_that_are_simple_nowhere_pass_through_themselves():
    random = np.random.default_rng(3)
    outline = Outline.of(Edges.among(SHEET))
    seen = set()
    for _ in range(300):
        size = random.choice([0.05, 0.2, 0.4, 0.8])
        turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
        position = np.pad(PLACE, ((0, 0), (0, 1))) @ turn
        position = position + size * random.normal(size=position.shape)
        seen.add((simple := outline.is_simple(position), crossed := crosses(position, SHEET)))
        assert not (simple and crossed)
    assert {(True, False), (False, True)} <= seen


@pytest.mark.parametrize(("turns", "simple"), [(0.6, True), (0.99, True), (1.2, False)])
def test_a_strip_around_a_point_is_simple_until_it_covers_itself(turns, simple):
    """All of its triangles show the same side: only its outline tells."""
    along, across = PLACE.T / [[ROWS - 1], [COLUMNS - 1]]
    angle, radius = 2 * np.pi * turns * along, 1.0 + across
    position = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0.0 * angle], axis=1)
    assert Outline.of(Edges.among(SHEET)).is_simple(position) == simple
    rising = position + [0, 0, 0.1] * along[:, None]
    assert not crosses(rising, SHEET)


def test_what_is_rolled_up_is_not_simple():
    angle = 0.9 * PLACE[:, 0]
    position = np.stack([np.cos(angle), np.sin(angle), PLACE[:, 1]], axis=1)
    assert not Outline.of(Edges.among(SHEET)).is_simple(position)


def test_only_sheets_with_one_closed_line_around_them_have_an_outline():
    assert Outline.of(Edges.among(SHEET)) is not None
    turned = SHEET.copy()
    turned[5] = turned[5, ::-1]
    apart = np.concatenate([SHEET, SHEET + ROWS * COLUMNS])
    closed = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
    thrice = np.concatenate([SHEET, [[0, 1, ROWS * COLUMNS]], [[1, 0, ROWS * COLUMNS + 1]]])
    for other in (RING, turned, apart, closed, thrice, SHEET[:0]):
        assert Outline.of(Edges.among(other)) is None
