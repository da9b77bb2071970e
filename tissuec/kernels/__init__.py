"""Arithmetic on bare arrays and SI numbers, as plain loops to be compiled.

Loops of forces are in ``forces``. Stepping code is written once against names of operations;
``compiled`` translates and calls all of them.

Shared arguments:
    time: Time [s].
    x: Positions of all nodes [m], flat, shape (3 node,).
    v: Velocities of all nodes [m/s], flat, shape (3 node,).
    a: Accelerations of all nodes [m/s²], flat, shape (3 node,).
    f: Forces on all nodes [N], flat, shape (3 node,); a kernel adds to them.
    x_end, v_end, a_end: The same as ``x``, ``v`` and ``a`` at the end of a step [s], shape (3
        node,).
    h: Size of the step [s].
    part, parts: Index of this thread's share of the loop, and the number of shares.
    team: The threads that share the loop.
    inverse_mass: One over the mass of each node, zero for held nodes [1/kg], shape (node,).
    acts: Tables of prescribed motions and loads.
    act: Index of a motion or load in ``acts``.
"""
