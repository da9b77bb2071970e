"""Contact and friction between nodes, faces, threads and tools."""
