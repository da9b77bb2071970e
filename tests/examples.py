"""How many examples Hypothesis tries: a tenth in the default run, all with THOROUGH=1."""

import os

IS_THOROUGH = bool(os.environ.get("THOROUGH"))


def examples(count: int) -> int:
    """Return how many of ``count`` examples are to be tried."""
    return count if IS_THOROUGH else max(count // 10, 10)
