"""Walls and hinges: triangles of surfaces that stretch and bend."""
