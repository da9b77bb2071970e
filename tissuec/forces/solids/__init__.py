"""Solid elements: stress at their points, memory, limits and muscle."""
