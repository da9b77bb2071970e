"""Arithmetic on bare arrays and SI numbers: the floor that the engine stands on.

Operations are plain loops, which ``building`` translates; those of forces stand in ``forces``.
Stepping code is written once against their names. Where it runs as Python itself,
``engine.tiers`` lets it call the compiled operations.
"""
