"""Fixtures that tests of other parts share: a browser, and a made-up result."""

from tests.browser import browser, page
from tests.results.conftest import example

__all__ = ["browser", "example", "page"]
