"""The sum of all forces and the resulting accelerations, as loops to be compiled.

They also run, slowly, as plain Python. What other modules do is compiled by itself and called
by its address: ``tissuec.kernels``.
"""

from math import sqrt

from tissuec.forces.acting.embedding_kernel import follow
from tissuec.forces.springs.branches_kernel import keep_still, remember
from tissuec.forces.springs.rest_length_kernel import reel
from tissuec.forces.springs.springs_kernel import reeled, springs
from tissuec.kernels.boundary_conditions import guide, prescribed, pull_free, put_driven
from tissuec.kernels.records import Fields, Floats, Net
from tissuec.kernels.thread_loops import PIECE, items_of, part_of, pieces_of, share
from tissuec.kernels.vectors import accumulate


def force(time: float, x: Floats, v: Floats, a: Floats, power: Floats, net: Net) -> bool:
    """Set ``a`` to the accelerations; return whether a spring is near to breaking.

    With a ledger, sets ``power`` to the work done from outside and to what is dissipated [W].

    Returns:
        Whether a spring is so close to its strength that the step needs a closer test.
    """
    power[0] = power[1] = 0.0
    if net.reeled:
        reel(time, net.rest, net.reels, net.acts)
        if net.ledger:
            power[0] -= reeled(time, x, v, net)
    near = springs(x, v, a, power, net)
    for group in range(net.fields.first.size - 1):
        first, last = int(net.fields.first[group]), int(net.fields.first[group + 1])
        share(net.team, add_fields, (first, last, time, x, v, a, net.fields))
        for k in range(first, last):
            power[0] += net.fields.power[k, 0]
            power[1] += net.fields.power[k, 1]
    if net.ledger:
        for node in net.driven:
            for i in range(3 * node, 3 * node + 3):
                power[0] -= a[i] * v[i]
    power[0] += pull_free(time, v, a, net.inverse_mass, net.acts)
    if net.ledger:
        share(net.team, count_powers, (v, net))
        for piece in range(pieces_of(net.inverse_mass.size)):
            power[0] += net.team.work[piece]
            power[1] += net.team.lost[piece]
    share(net.team, accelerate, (v, a, net))
    if net.guided:
        power[0] += guide(a, v, net.inverse_mass, net.guides)
    if net.touched:
        for k in range(net.touches.memory.size):
            i = 3 * net.touches.memory[k]
            for c in range(3):
                a[i + c] = net.touches.bent[k, c]
    if net.inelastic:
        remember(a, net.internal)
    if net.embedded:
        follow(a, net.embedding)
    return near


def count_powers(part: int, parts: int, v: Floats, net: Net) -> None:
    """Sum the power of constant loads and of drag, for each piece of a part of the nodes."""
    first, last = part_of(part, parts, net.inverse_mass.size)
    for start in range(first, last, PIECE):
        stop = min(start + PIECE, last)
        # Views that are indexed from 0 need no test of whether an index is negative.
        own_v, push = v[3 * start : 3 * stop], net.push[3 * start : 3 * stop]
        mass, drags = net.inverse_mass[start:stop], net.drag[start:stop]
        # Three sums each, of which an addition need not wait for the last one.
        work0 = work1 = work2 = lost0 = lost1 = lost2 = 0.0
        for node in range(mass.size):
            drag, i = drags[node] if mass[node] > 0.0 else 0.0, 3 * node
            v0, v1, v2 = own_v[i], own_v[i + 1], own_v[i + 2]
            work0 += push[i] * v0
            work1 += push[i + 1] * v1
            work2 += push[i + 2] * v2
            lost0 += drag * v0 * v0
            lost1 += drag * v1 * v1
            lost2 += drag * v2 * v2
        net.team.work[start // PIECE] = work0 + work1 + work2
        net.team.lost[start // PIECE] = lost0 + lost1 + lost2


def accelerate(part: int, parts: int, v: Floats, a: Floats, net: Net) -> None:
    """Convert forces on a part of the nodes to accelerations, with drag and constant loads.

    Here ``a`` contains forces [N] before and accelerations [m/s²] after the call.
    """
    begin, end = part_of(part, parts, net.inverse_mass.size)
    # Forces of a piece stay in the cache; of large nets, anything else takes time to be read.
    for first in range(begin, end, PIECE):
        last = min(first + PIECE, end)
        # Views that are indexed from 0 need no test of whether an index is negative.
        own, mass = a[3 * first : 3 * last], net.response[first:last]
        if net.dragged:
            add_drag(net.drag[first:last], v[3 * first : 3 * last], own)
        for node in range(mass.size):
            inverse, i = mass[node], 3 * node
            # One by one, which vector instructions take apart, as they do not with a loop.
            own[i] *= inverse
            own[i + 1] *= inverse
            own[i + 2] *= inverse
        if net.pushed:
            accumulate(1.0, net.steady[3 * first : 3 * last], own)


def add_drag(drags: Floats, v: Floats, f: Floats) -> None:
    """Add the forces of drag on some nodes.

    Args:
        drags: Drag [N s/m], shape (node,).
    """
    for node in range(drags.size):
        drag, i = drags[node], 3 * node
        f[i] -= drag * v[i]
        f[i + 1] -= drag * v[i + 1]
        f[i + 2] -= drag * v[i + 2]


def add_fields(
    part: int,
    parts: int,
    first: int,
    last: int,
    time: float,
    x: Floats,
    v: Floats,
    f: Floats,
    fields: Fields,
) -> None:
    """Add the forces of some fields that have no node in common, and set their powers.

    Args:
        first, last: Fields from ``first`` up to before ``last``, of which this is a part.
        fields: All fields.
    """
    begin, end = items_of(part, parts, last - first)
    for k in range(first + begin, first + end):
        fields.power[k, 0] = fields.power[k, 1] = 0.0
        add_field(fields.address[k], fields.table[k], time, x, v, f, fields.power[k])


def add_field(
    address: int, table: int, time: float, x: Floats, v: Floats, f: Floats, power: Floats
) -> None:
    """Call the kernel of a field with its table; see ``tissuec.forces``.

    Compiled code replaces this by a call of the address; Python cannot call it.

    Args:
        address: Address of the compiled kernel.
        table: Address of the table that it reads.

    Raises:
        NotImplementedError: Always, where it runs as Python.
    """
    raise NotImplementedError


def place(time: float, x: Floats, v: Floats, net: Net) -> None:
    """Set driven and embedded nodes, and rest lengths, to what they are at a time."""
    put_driven(time, x, v, net.acts)
    if net.reeled:
        reel(time, net.rest, net.reels, net.acts)
    keep_still(x, net.internal_rows)
    if net.touched:
        keep_still(x, net.touches.memory)
    if net.inelastic:
        keep_still(x, net.internal.rows)
    if net.embedded:
        follow(x, net.embedding)
        follow(v, net.embedding)


def kinetic(v: Floats, net: Net) -> float:
    """Return the kinetic energy of the free nodes [J]."""
    total = 0.0
    for node in range(net.inverse_mass.size):
        if net.inverse_mass[node] > 0.0:
            i = 3 * node
            total += (v[i] ** 2 + v[i + 1] ** 2 + v[i + 2] ** 2) / net.inverse_mass[node]
    if net.guided:
        total -= prescribed(v, net.inverse_mass, net.guides)
    return 0.5 * total


def greatest_force(a: Floats, net: Net) -> float:
    """Return the largest force on a free node, from the accelerations [N].

    Returns:
        The largest force [N]; NaN if a force is not finite.
    """
    greatest = check = 0.0
    for node in range(net.inverse_mass.size):
        inverse, i = net.inverse_mass[node], 3 * node
        if inverse > 0.0:
            force = (a[i] * a[i] + a[i + 1] * a[i + 1] + a[i + 2] * a[i + 2]) / inverse**2
            greatest = max(greatest, force)
            check += 0.0 * force  # what is not finite must not get lost in a maximum
    return sqrt(greatest) + check


def greatest_inner_force(time: float, v: Floats, a: Floats, out: Floats, net: Net) -> float:
    """Return the largest force on a free node without weight, loads and drag [N].

    Args:
        out: Scratch, shape (3 node,).
    """
    for i in range(out.size):
        out[i] = 0.0
    pull_free(time, v, out, net.inverse_mass, net.acts)
    for node in range(net.inverse_mass.size):
        inverse = net.inverse_mass[node]
        for i in range(3 * node, 3 * node + 3):
            out[i] = a[i] - net.steady[i] + inverse * (net.drag[node] * v[i] - out[i])
    return greatest_force(out, net)
