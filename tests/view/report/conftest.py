"""What tests of reports share: a made-up result, and pages without drawings."""

import pytest

from tests.results.conftest import example
from tissuec.view.report import page

__all__ = ["example"]


@pytest.fixture
def without_pictures(monkeypatch):
    """Pictures take time, and have tests of their own."""
    monkeypatch.setattr(page, "lacking", lambda: "there is no time for pictures")
