"""Measures of vectors of all nodes, in pieces and by several threads."""

import numpy as np
import pytest

from tissuec.compiled.calls import Shipped
from tissuec.engine.threads import ThreadTeam
from tissuec.kernels import vectors
from tissuec.kernels.thread_loops import PIECE

NODES = 3 * PIECE + 7


def compiled(function):
    return Shipped(function, "vectors")


@pytest.fixture(params=[1, 2])
def team(request):
    with ThreadTeam(request.param, NODES) as threads:
        yield threads.record


@pytest.fixture
def pair():
    return np.random.default_rng(5).normal(size=(2, NODES, 3))


@pytest.mark.parametrize("of", [lambda f: f, compiled], ids=["Python", "compiled"])
@pytest.mark.parametrize("node", [0, PIECE - 1, PIECE, NODES - 1])
def test_the_largest_length_and_distance_are_found_wherever_they_are(of, node, pair, team):
    one, two = pair
    one[node] = 9.0, -9.0, 9.0
    scratch = np.zeros(NODES)
    length = np.linalg.norm(one, axis=1).max()
    distance = np.linalg.norm(one - two, axis=1).max()
    flat, other = one.ravel(), two.ravel()
    assert of(vectors.length)(flat, scratch, team) == pytest.approx(length, rel=1e-15)
    found = of(vectors.distance)(flat, other, scratch, team)
    assert found == pytest.approx(distance, rel=1e-15)


def test_threads_wake_and_sleep_again_and_again(pair):
    """Also where they have no loop to share, or wake when it has ended already."""
    vector, scratch = pair[0].ravel(), np.zeros(NODES)
    largest = vectors.length(vector, scratch, ThreadTeam(1, NODES).record)
    for number in (2, 5):
        team = ThreadTeam(number, NODES)
        for turn in range(2000):
            with team:
                for _ in range(turn % 4):
                    assert compiled(vectors.length)(vector, scratch, team.record) == largest


@pytest.mark.parametrize("of", [lambda f: f, compiled], ids=["Python", "compiled"])
@pytest.mark.parametrize("component", [0, 3 * PIECE + 1, 3 * NODES - 1])
def test_what_is_not_a_number_is_not_lost_in_a_maximum(of, component, pair, team):
    one, two = pair.reshape(2, -1)
    one[component] = np.nan
    scratch = np.zeros(NODES)
    assert np.isnan(of(vectors.length)(one, scratch, team))
    assert np.isnan(of(vectors.distance)(one, two, scratch, team))


def test_nodes_beyond_the_scratch_do_not_count(pair, team):
    one, two = pair.reshape(2, -1)
    one[-3:] = 100.0
    fewer = np.zeros(NODES - 1)
    assert vectors.length(one, fewer, team) < 10.0
    assert vectors.distance(one, two, fewer, team) < 20.0


@pytest.mark.parametrize("of", [lambda f: f, compiled], ids=["Python", "compiled"])
def test_velocities_are_corrected_and_the_largest_change_found(of, pair, team):
    before, after = pair
    after[NODES // 2] = 9.0
    predicted = np.random.default_rng(6).normal(size=(NODES, 3))
    expected = predicted + 0.05 * (after - before)
    largest = np.linalg.norm(after - before, axis=1).max()
    flat = predicted.ravel()
    given = before.ravel(), after.ravel(), 0.1, flat, np.zeros(NODES), team
    assert of(vectors.correct)(*given) == pytest.approx(largest, rel=1e-15)
    # One multiplication and addition, which compiled code rounds once.
    np.testing.assert_allclose(flat.reshape(-1, 3), expected, atol=1e-15)
