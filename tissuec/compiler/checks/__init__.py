"""Checks of a compiled scene: one small generator per rule, each yields diagnostics.

All of them are warnings about scenes that can be run but may not mean what their author thinks.
"""

from collections.abc import Callable, Iterator
from typing import TypeVar

from msgspec import Struct

from tissuec.compiler.compile import Compiled
from tissuec.core.errors import Diagnostic
from tissuec.core.registry import Family

R = TypeVar("R", bound=Callable[..., Iterator[Diagnostic]])


class Check(Struct, frozen=True):
    """A rule.

    Attributes:
        find: Yields what is doubtful in a scene.
        is_thorough: Whether it takes time, or is useful on request only.
    """

    find: Callable[[Compiled], Iterator[Diagnostic]]
    is_thorough: bool


CHECKS: Family[Check] = Family("tissuec.compiler.checks", "check")


def check(rule: R) -> R:
    """Enter a generator over a compiled scene, which every command applies."""
    CHECKS.member(rule.__name__)(Check(rule, is_thorough=False))
    return rule


def thorough_check(rule: R) -> R:
    """Enter a generator that takes time, or is useful on request only: for ``check``."""
    CHECKS.member(rule.__name__)(Check(rule, is_thorough=True))
    return rule


def check_all(compiled: Compiled, *, thorough: bool) -> list[Diagnostic]:
    """Return the warnings of every check.

    Args:
        compiled: The scene.
        thorough: Whether to make also thorough checks.
    """
    checks = (each for each in CHECKS.values() if thorough or not each.is_thorough)
    return [finding for each in checks for finding in each.find(compiled)]
