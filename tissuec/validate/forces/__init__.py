"""What acts on the nodes, in formulas of the reference's own.

Nothing here, and nothing that these modules import, computes a force for the engine: numbers
come from a ``Situation`` as plain attributes, and docs/numerics.md is what both implement.
"""
