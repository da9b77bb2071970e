"""Differences between two runs, two scenes, or a scene and a run: text, numbers, motion.

Shared arguments:
    a, b: The two sides.
    nodes: Nodes that both have.
    springs: Springs that both have.
    name: Name of the log.
    times: Times [s], shape (time,).
"""
