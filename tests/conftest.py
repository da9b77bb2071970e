"""What tests share: where the repository is, and a browser."""

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.browser import browser as browser
from tests.browser import page as page


@pytest.fixture(scope="session")
def repository() -> Path:
    return Path(__file__).resolve().parent.parent


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Have Ctrl-C mean what it does at a prompt; shells make background jobs ignore it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
