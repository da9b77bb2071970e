"""Meshes: generators, file formats, and repair of what files contain."""
