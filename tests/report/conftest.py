"""What tests of other parts share: a made-up result."""

from tests.results.conftest import example

__all__ = ["example"]
