"""Types of the part of ``numba.core.imputils`` that tissuec uses."""

from collections.abc import Callable
from typing import Any, TypeVar

from numba.core.types import Type

F = TypeVar("F", bound=Callable[..., Any])

def lower_getattr_generic(ty: type[Type]) -> Callable[[F], F]: ...
def lower_setattr_generic(ty: type[Type]) -> Callable[[F], F]: ...
