"""The finding of a text that does not compile."""

from collections.abc import Callable
from typing import Any

import pytest

from tissuec.core.errors import CompileError, Diagnostic


def finding_of(act: Callable[..., Any], *values: Any, **named: Any) -> Diagnostic:
    """Return the only finding with which a call fails.

    Args:
        act: What is called.
        values, named: With which.
    """
    with pytest.raises(CompileError) as caught:
        act(*values, **named)
    (found,) = caught.value.diagnostics
    return found
