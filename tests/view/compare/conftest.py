"""Comparisons of texts."""

import pytest

import tissuec
from tissuec.core.source import Source
from tissuec.scene.request import Request
from tissuec.view.compare.comparison import compare
from tissuec.view.compare.sides import of_result, of_scene


@pytest.fixture
def scene():
    """Return a text as one side of a comparison."""
    return lambda text: of_scene(Request(Source("scene", text)))


@pytest.fixture(scope="session")
def first_run():
    """Return a function that gives the run of a text, the same one for all tests."""
    runs = {}

    def of(text):
        return runs.get(text) or runs.setdefault(text, tissuec.run(text))

    yield of
    for one in runs.values():
        one.close()


@pytest.fixture
def compared(scene, first_run):
    """Compare texts: what they compile to, or with ``run`` what comes of them."""
    runs = []

    def second_run(text):
        runs.append(tissuec.run(text))
        return runs[-1]

    def of(a, b, *, run=False):
        if not run:
            return compare(scene(a), scene(b))
        return compare(of_result(first_run(a)), of_result(second_run(b)))

    yield of
    for one in runs:
        one.close()


@pytest.fixture(scope="session")
def told():
    """Return a comparison as the text that people read."""
    from tissuec.core.report import as_text
    from tissuec.view.compare.report import parts_of

    return lambda found: "\n".join(as_text(parts_of(found)))
