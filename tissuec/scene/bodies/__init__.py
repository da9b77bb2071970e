"""Bodies: meshes placed, tissues of their parts, and joints between them."""
