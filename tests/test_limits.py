"""Limits that stand in two places, because neither may see the other, agree."""

from tissuec.engine import engine
from tissuec.scene import settings


def test_the_language_refuses_the_tolerances_that_the_engine_refuses() -> None:
    assert settings.FINEST_TOLERANCE == engine.FINEST_TOLERANCE
