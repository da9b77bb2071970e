"""Arithmetic on bare arrays and SI numbers: the floor that the engine stands on.

``scalar`` holds each operation as a plain loop, which ``building`` translates. Stepping code is
written once against these names. Where it runs as Python itself, ``engine.tiers`` lets it call
compiled operations on nets, and ``vector`` for the others.
"""
