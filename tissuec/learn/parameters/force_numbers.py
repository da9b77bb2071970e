"""Numbers of forces that exact derivatives do not cover.

A field has derivatives by some of its columns. A number of a force block that enters others,
such as an exponent, has no exact derivatives.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from msgspec.structs import fields

from tissuec.compiler.compile import Compiled
from tissuec.forces import Field
from tissuec.learn.parameters.blocks import ParameterBlock
from tissuec.learn.parameters.compilations import STEP
from tissuec.learn.parameters.fields import derivatives_of
from tissuec.learn.parameters.substitution import recompiled
from tissuec.model.blocks import name_of_force


def not_derived(compiled: Compiled, blocks: Sequence[ParameterBlock]) -> str:
    """Return the first adjusted number whose effect has no exact derivatives; "" without any.

    Args:
        blocks: Of each entry of a fit problem.
    """
    for block in blocks:
        if not block.is_of_force:
            continue
        field = _force(compiled, block.adjust.of)
        if isinstance(field.derivatives, str):
            continue
        value = float(block.start[0])
        key = block.places[0], block.adjust.what
        moved = recompiled(compiled, {key: value + STEP * (abs(value) or 1.0)}, {})
        if _differs(field, _force(moved, block.adjust.of)):
            return block.names[0]
    return ""


def _force(compiled: Compiled, name: str) -> Field:
    """Return the field of a ``force`` block."""
    return next(b.field for b in compiled.network.blocks if b.name == name_of_force(name))


def _differs(field: Field, other: Field) -> bool:
    """Return whether anything but the columns of a field is otherwise in another one."""
    columns = derivatives_of(field).columns
    names = (one.name for one in fields(field) if one.name not in columns)
    pairs: list[tuple[Any, Any]] = [(getattr(field, n), getattr(other, n)) for n in names]
    return not all(np.array_equal(one, two) for one, two in pairs)
