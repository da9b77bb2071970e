"""Exact derivatives of the forces of fields, for learning.

A field that has them names the ``columns`` of numbers that its forces depend on, and two loops
beside its kernel, which get the same table:

    ``pull_back`` adds the derivatives of Σ weight · f by positions, velocities and numbers;
    ``push_forward`` adds the changes of f for many changes of these.

They are transposes of each other. Numbers are those of one column after the other, each flat in
its own order.

Arguments of both are ``time, x, v`` as of the kernel, and

    weight: Any weights of the forces of all nodes, shape (3 node,).
    by_x, by_v: Derivatives by positions and velocities, added to, shape (3 node,).
    by: Derivatives by numbers, added to, shape (number,).
    dx, dv: Changes of positions and velocities, shape (3 node change,): all of one component
        together.
    dn: Changes of numbers, shape (number change,).
    df: Changes of the forces, added to, shape (3 node change,).
    room: Scratch, shape (change,).
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from msgspec.structs import replace

from tissuec.model.network import Floats, Indices


class ForceDerivatives(NamedTuple):
    """How the forces of a field depend on positions, velocities and its own numbers."""

    columns: tuple[str, ...]  # fields of the field: numbers, or arrays with a row for each item
    pull_back: Callable[..., None]
    push_forward: Callable[..., None]


def numbers_of(field: Any, columns: tuple[str, ...]) -> Floats:
    """Return the numbers of a field, in SI units, shape (number,)."""
    parts = [np.ravel(getattr(field, name)) for name in columns]
    return np.concatenate([np.zeros(0), *parts])


def with_numbers(field: Any, columns: tuple[str, ...], numbers: Floats) -> Any:
    """Return a field with other numbers.

    Args:
        field: The field.
        columns: Names of its columns.
        numbers: In SI units, shape (number,).
    """
    found: dict[str, Any] = {}
    start = 0
    for name in columns:
        old: Floats | float = getattr(field, name)
        size = np.size(old)
        part = numbers[start : start + size]
        if isinstance(old, np.ndarray):
            found[name] = part.reshape(old.shape).copy()
        else:
            found[name] = float(part[0])
        start += size
    return replace(field, **found)


def places_of(field: Any, columns: tuple[str, ...], lost: Indices) -> Indices:
    """Return which numbers of a field are left when it loses some of its items, shape (n,).

    Args:
        field: The field.
        columns: Names of its columns.
        lost: Indices of the items, shape (item,).
    """
    parts = [np.zeros(0, dtype=np.int64)]
    start = 0
    for name in columns:
        value = np.asarray(getattr(field, name))
        numbers = start + np.arange(value.size).reshape(value.shape)
        parts.append((np.delete(numbers, lost, axis=0) if value.ndim else numbers).ravel())
        start += value.size
    return np.concatenate(parts)
