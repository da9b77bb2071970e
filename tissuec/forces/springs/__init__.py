"""Springs of nets: their loops, laws, branches and rest lengths."""
