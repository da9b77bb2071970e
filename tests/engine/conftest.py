"""What tests of the engine share."""

import pytest

from tissuec.engine import threads


@pytest.fixture
def threads_in_small_nets(monkeypatch):
    """Let threads share the loops of nets of any size."""
    monkeypatch.setattr(threads, "LEAST_SPRINGS", 1)
