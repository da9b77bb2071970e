"""Forces: each follows from a potential, or has its loop and matrix beside its parameters.

The folders are ``springs`` (with their laws and viscoelastic branches), ``surfaces``,
``solids``, ``contact``, ``enclosed`` and ``acting``. Long loops have a file of their own, whose
name ends in ``kernel``.
Springs come first. Every other force is an ``Effect``: ``Nodal`` if it acts on each node
independently (weight, drag, loads), ``Field`` if it depends on positions (volumes, bending,
contact, jets, foundations). Fields are the blocks of a net beside its springs, each under a
name and a kind (``model.blocks``). ``PotentialField``, ``PooledField`` and ``PointField``
derive all that a field needs from the potential of an item, of sums over items, or of a point
of an element.
``mechanics.state`` collects effects and ``accelerations`` sums them.

Shared arguments:
    time: Time [s].
    position: Of all nodes [m], shape (…, node, 3), or (node, 3) where the result is one number
        or matrix.
    velocity: Of all nodes [m/s], shape as ``position``.
    number: Of each node among those that may move, -1 for others, shape (node,).
    size: Number of nodes that may move; matrices have the shape (3 size, 3 size).
    x: Positions of all nodes [m], flat, shape (3 node,).
    v: Velocities of all nodes [m/s], flat, shape (3 node,).
    a: Accelerations of all nodes [m/s²], flat, shape (3 node,).
    f: Forces on all nodes [N], flat, shape (3 node,); a kernel adds to them.
    power: Power supplied from outside and power dissipated [W], shape (2,); a kernel adds to
        them.
    part, parts: Index of this thread's share of the loop, and the number of shares.
    net: Record of the network; its fields give the shapes and units.
    weight, by_x, by_v, dx, dv, df, room: Of derivatives, see ``forces.matrices``; shapes
        (3 node,), (3 node change,) and (change,), in any unit.
"""
