"""Elastic constants of nets, plates of walls, and where springs break."""
