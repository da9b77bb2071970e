"""Records of derivatives for learning, and what their loops call by addresses."""

from typing import NamedTuple

from tissuec.kernels.records import Floats, IntegerRows, Integers, Rows


def of_law(*values: object) -> float:
    """Refuse the call: compiled code calls laws by their addresses.

    Raises:
        TypeError: Always.
    """
    raise TypeError("laws are called by compiled code only")


pull = pull_by_c = pull_by_rest = slope = of_law
brake = brake_by_d = brake_by_e = brake_by_rest = brake_slope = by_constant = of_law


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


class Laws(NamedTuple):
    """Laws of springs and their partial derivatives, as addresses of compiled functions.

    They are 0 where all springs are linear.
    """

    curved: bool  # some springs have laws that are not linear
    brake: int = 0
    brake_by_d: int = 0
    brake_by_e: int = 0
    brake_by_rest: int = 0
    brake_slope: int = 0
    by_constant: int = 0
    pull: int = 0
    pull_by_c: int = 0
    pull_by_rest: int = 0
    slope: int = 0


class Links(NamedTuple):
    """Everything that acts between two events.

    Attributes:
        low, high: Nodes of the springs that act, shape (spring,).
        spring: Their numbers in the network, shape (spring,).
        law: Their laws, shape (spring,).
        inverse: 1/m of free nodes, 0 of held ones [1/kg], shape (node,).
        steady: Acceleration by gravity, 0 of held nodes [m/s²], shape (3 node,).
        drag: Ambient damping [N s/m], shape (node,).
        loaded: Nodes with loads that change in time, shape (loaded,).
        driven: Nodes that are moved, shape (driven,).
    """

    low: Integers
    high: Integers
    spring: Integers
    law: Integers
    inverse: Floats
    steady: Floats
    drag: Floats
    loaded: Integers
    driven: Integers


class Values(NamedTuple):
    """Numbers that can be learnt, or their derivatives, in the order of the network.

    Attributes:
        mass: [kg], shape (node,).
        stiffness, damping, rest: c [N/m], d [N s/m], L0 [m], shape (spring,).
        constants: Of laws, shape (constant,).
        drag: Ambient damping besides that of all nodes alike [N s/m], shape (node,).
        fields: Of the fields that act, one after the other, shape (number,).
        memory: Of springs that remember: c1 [N/m] of each branch, then 1/τ [1/s] of each, F [N]
            and 1/η [m/(N s)], 0 where there is none, shape (row spring,).
    """

    mass: Floats
    stiffness: Floats
    damping: Floats
    rest: Floats
    constants: Floats
    drag: Floats
    fields: Floats
    memory: Floats


class SpringMemory(NamedTuple):
    """Springs that remember and act; see ``springs.branches_derivatives_kernel``.

    Attributes:
        low, high: Their nodes, shape (n,).
        spring: Their numbers in the network, shape (n,).
        law: Their laws, shape (n,).
        slot: Components of velocities that are q of each branch and last p, -1 where there is
            none, shape (n, branch + 1).
        rate: What these are multiplied by [1/s], shape (n, branch + 1).
        springs: How many springs the network has.
    """

    low: Integers
    high: Integers
    spring: Integers
    law: Integers
    slot: IntegerRows
    rate: Rows
    springs: int


class ActingFields(NamedTuple):
    """Fields that act beside springs: addresses of their loops and tables.

    Attributes:
        force, pull_back, push_forward: Of loops, see ``forces.matrices``, shape (field,).
        table: Of what they read, shape (field,).
        first: Numbers of field k are first[k]:first[k + 1] of ``Values.fields``, shape
            (field + 1,).
        weight: Scratch, shape (3 node,), or (0,) without fields.
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

    laws: Laws
    links: Links
    values: Values
    fields: ActingFields
    memory: SpringMemory


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
    stiffness: Sparse
    damping: Sparse
    rest: Sparse
    constants: Sparse
    drag: Sparse
    fields: Floats  # of ``Values.fields``, not sparse, shape (number change,)
    memory: Floats  # of ``Values.memory``, not sparse, shape (number change,)
    total: Floats  # scratch, shape (change,)
    room: Rows  # scratch, shape (3, change)


class Reach(NamedTuple):
    """What leads from the lower node of a spring to the upper one.

    Attributes:
        length: L [m].
        inverse: 1/L [1/m], 0 at zero length.
        n0, n1, n2: Direction, 0 at zero length.
        u0, u1, u2: Velocity of the upper node less that of the lower one [m/s].
        w: Rate of the length [m/s].
    """

    length: float
    inverse: float
    n0: float
    n1: float
    n2: float
    u0: float
    u1: float
    u2: float
    w: float


class Slopes(NamedTuple):
    """Derivatives of f(e) and g(e, w) of a spring.

    Attributes:
        steep, thick: f' [N/m], and ∂g/∂e [N/m].
        brisk: ∂g/∂w [N s/m].
        by_c, by_rest: Of f, by c and L0.
        by_d, braked: Of g, by d and L0.
    """

    steep: float
    thick: float
    brisk: float
    by_c: float
    by_rest: float
    by_d: float
    braked: float


class Response(NamedTuple):
    """The derivatives of a spring's force.

    Attributes:
        z: What leads from its lower node to the upper one.
        e: Elongation [m].
        across: T / L, of the force by a place across the spring [N/m].
        steep: Of the tension by the elongation [N/m].
        brisk: ∂g/∂w, of the tension by the upper node's velocity along the spring [N s/m].
        by_c, by_d, by_rest: Of the tension by c, d and L0.
    """

    z: Reach
    e: float
    across: float
    steep: float
    brisk: float
    by_c: float
    by_d: float
    by_rest: float
