"""Walls: triangles of surfaces that stretch and bend."""
