"""Comparisons of texts."""

import pytest

import tissuec
from tissuec.comparing.comparison import compare
from tissuec.comparing.sides import of_result, of_scene
from tissuec.core.source import Source
from tissuec.pipeline import Request


@pytest.fixture
def scene():
    """Return a text as one side of a comparison."""
    return lambda text: of_scene(Request(Source("scene", text)))


@pytest.fixture
def compared(scene):
    """Compare texts: what they compile to, or with ``run`` what comes of them."""
    runs = []

    def side(text, run):
        if not run:
            return scene(text)
        runs.append(tissuec.run(text))
        return of_result(runs[-1])

    yield lambda a, b, *, run=False: compare(side(a, run), side(b, run))
    for one in runs:
        one.close()


@pytest.fixture(scope="session")
def told():
    """Return a comparison as the text that people read."""
    from tissuec.comparing.wording import as_text

    return lambda found: "\n".join(as_text(found))
