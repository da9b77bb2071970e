"""Arithmetic on bare arrays and SI numbers, and its machine code.

Operations are plain loops; those of forces are in ``forces``. ``engine.codegen`` translates
them into LLVM's intermediate representation, which is in ``shipped``. ``loading``
optimises that for this processor, once, and keeps it in the user's cache; ``compiled_laws``
translates laws of springs where a scene has some. Stepping code is written once against names
of operations. Where it runs as Python itself, ``engine.backends`` lets it call compiled ones.

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
