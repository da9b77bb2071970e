"""Types of the part of ``numba.core.typing.templates`` that tissuec uses."""

from typing import Any, TypeVar

from numba.core.types import Type

C = TypeVar("C", bound=type)

class Signature:
    return_type: Type
    args: tuple[Any, ...]  # types, each with what only its own class has

class AttributeTemplate:
    key: type[Type]

def infer_getattr(template: C) -> C: ...
