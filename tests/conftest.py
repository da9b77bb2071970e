"""What tests share: where the repository is, and a browser."""

from pathlib import Path

import pytest

from tests.browser import browser as browser
from tests.browser import page as page


@pytest.fixture(scope="session")
def repository() -> Path:
    return Path(__file__).resolve().parent.parent
