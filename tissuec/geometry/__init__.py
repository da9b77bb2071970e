"""Geometry of points, lines, triangles and closed surfaces."""
