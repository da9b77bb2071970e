"""Types of the part of ``numba.core.types`` that tissuec uses."""

from numba.core.typing.templates import Signature

class Type:
    def __init__(self, name: str) -> None: ...
    def __call__(self, *args: Type) -> Signature: ...

class Array(Type):
    dtype: Type
    def __init__(self, dtype: Type, ndim: int, layout: str) -> None: ...

boolean: Type
float64: Type
int32: Type
int64: Type
none: Type
