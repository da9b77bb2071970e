"""Calls of a function that are counted while a test runs."""

from typing import Any

import pytest


def counted(monkeypatch: pytest.MonkeyPatch, owner: Any, name: str) -> list[int]:
    """Return a list that grows with each call of a function or method from now on.

    Args:
        owner: The module or class that has it.
        name: Of the function.
    """
    calls, given = list[int](), getattr(owner, name)

    def counting(*each: Any, **more: Any) -> Any:
        calls.append(1)
        return given(*each, **more)

    monkeypatch.setattr(owner, name, counting)
    return calls
