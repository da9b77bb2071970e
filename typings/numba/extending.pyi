"""Types of the part of ``numba.extending`` that tissuec uses."""

from collections.abc import Callable
from types import ModuleType
from typing import Any, TypeVar

from numba.core.types import Type

C = TypeVar("C", bound=type)
F = TypeVar("F", bound=Callable[..., Any])

class NativeValue:
    def __init__(self, value: Any) -> None: ...

class _Registry:
    def register(self, cls: type) -> Callable[[F], F]: ...

models: ModuleType
typeof_impl: _Registry

def intrinsic(func: F) -> F: ...
def register_model(fe_type_class: type[Type]) -> Callable[[C], C]: ...
def unbox(typeclass: type[Type]) -> Callable[[F], F]: ...
