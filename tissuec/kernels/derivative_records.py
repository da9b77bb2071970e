"""Records of derivatives for learning, and what their loops call by addresses."""

from typing import NamedTuple

from tissuec.kernels.records import Floats, Integers, Rows


def of_field(address: int, table: int, time: float, *vectors: Floats) -> None:
    """Refuse the call: compiled code calls the loops of fields by their addresses.

    Args:
        address: Of the loop.
        table: Address of what it reads.
        time: [s].
        vectors: What it takes beside, each of shape (n,).

    Raises:
        TypeError: Always.
    """
    raise TypeError("fields are called by compiled code only")


call_force = call_pull_back = call_push_forward = of_field


class Links(NamedTuple):
    """Nodes between two events.

    Attributes:
        inverse: 1/m of free nodes, 0 of held ones [1/kg], shape (node,).
        steady: Acceleration by gravity, 0 of held nodes [m/s²], shape (3 node,).
        drag: Ambient damping [N s/m], shape (node,).
        loaded: Nodes with loads that change in time, shape (loaded,).
        driven: Nodes that are moved, shape (driven,).
    """

    inverse: Floats
    steady: Floats
    drag: Floats
    loaded: Integers
    driven: Integers


class Values(NamedTuple):
    """Numbers that can be learnt, or derivatives by them.

    Attributes:
        mass: [kg], shape (node,).
        drag: Ambient damping besides that of all nodes alike [N s/m], shape (node,).
        numbers: Of the springs and fields that act, one after the other, shape (number,).
    """

    mass: Floats
    drag: Floats
    numbers: Floats


class ActingFields(NamedTuple):
    """Springs and fields that act: addresses of their loops and tables.

    Attributes:
        force, pull_back, push_forward: Of loops, see ``forces.matrices``, shape (field,).
        table: Of what they read, shape (field,).
        first: Numbers of field k are first[k]:first[k + 1] of ``Values.numbers``, shape
            (field + 1,).
        weight: Scratch, shape (3 node,).
        power: Scratch, shape (2,).
        kept: What addresses are of, for Python only.
    """

    force: Integers
    pull_back: Integers
    push_forward: Integers
    table: Integers
    first: Integers
    weight: Floats
    power: Floats
    kept: object = ()


class Forces(NamedTuple):
    """Everything that accelerations depend on, except state and changing loads."""

    links: Links
    fields: ActingFields


class NodeState(NamedTuple):
    """Places, velocities and accelerations, or derivatives by them, shape (3 node,).

    Many changes of them are flat, shape (3 node change,), all of one component together.
    """

    x: Floats
    v: Floats
    a: Floats


class NodeStates(NamedTuple):
    """Many of these, shape (state, 3 node)."""

    x: Rows
    v: Rows
    a: Rows


class Sparse(NamedTuple):
    """A matrix: row i has ``entries`` from ``rows[i]`` to ``rows[i + 1]`` in ``columns``."""

    rows: Integers
    columns: Integers
    entries: Floats


class Seeds(NamedTuple):
    """Derivatives of numbers by parameters: for each array a row for each of its numbers."""

    mass: Sparse
    drag: Sparse
    numbers: Floats  # of ``Values.numbers``, not sparse, shape (number change,)
    room: Floats  # scratch, shape (change,)
