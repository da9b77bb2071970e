"""Scene to Network and Plan: meshes built, words turned into arrays, sentences into actions."""
