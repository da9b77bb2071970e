"""What becomes of calls that a cluster has under way."""

from concurrent.futures import Future

import pytest

from tissuec.core.errors import TissueError
from tissuec.core.workers.cluster import Cluster
from tissuec.core.workers.portions import WorkerDied


class KilledWorker(Exception):
    """As dask calls the death of a worker."""


def passed(inner, outer):
    """Give an answer to who waits for it; no scheduler is needed for that."""
    cluster = object.__new__(Cluster)
    cluster.address = "tcp://here:1"
    cluster._pass(inner, outer)


def ended(*, result=None, error=None, cancelled=False):
    future = Future()
    if cancelled:
        future.cancel()
    elif error is None:
        future.set_result(result)
    else:
        future.set_exception(error)
    return future


ANSWERS = [
    {"result": 7},
    {"error": ValueError("wrong")},
    {"error": KilledWorker()},
    {"cancelled": True},
]


@pytest.mark.parametrize("answer", ANSWERS)
def test_a_call_that_was_given_up_takes_no_answer(answer):
    """As after Ctrl-C, when dask would print a traceback for each of them."""
    outer = Future()
    outer.cancel()
    passed(ended(**answer), outer)
    assert outer.cancelled()


@pytest.mark.parametrize(
    ("answer", "kind"), zip(ANSWERS[1:], (ValueError, WorkerDied, TissueError), strict=True)
)
def test_errors_reach_who_waits(answer, kind):
    outer = Future()
    passed(ended(**answer), outer)
    with pytest.raises(kind):
        outer.result(timeout=0)


def test_a_result_reaches_who_waits():
    outer = Future()
    passed(ended(result=7), outer)
    assert outer.result(timeout=0) == 7
