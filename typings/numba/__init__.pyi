"""Types of the part of Numba that tissuec uses; Numba has its own for some of its modules."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numba.core.types import Type

def from_dtype(dtype: np.dtype[Any]) -> Type: ...
def njit(**options: object) -> Callable[[Callable[..., Any]], Any]: ...
