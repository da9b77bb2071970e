"""What tests of pictures share: figures that are not laid out."""

import pytest

from tissuec.view.plots import page


@pytest.fixture
def placed() -> None:
    """Lay axes out also where ``unplaced`` is the rule."""


@pytest.fixture
def unplaced(request, monkeypatch) -> None:
    """Leave axes where they begin: to lay them out takes half of the time of a figure.

    ``test_kinds.py`` looks at figures of every kind as they are laid out.
    """
    if "placed" not in request.fixturenames:
        monkeypatch.setattr(page, "_lay_out", lambda figure: None)
