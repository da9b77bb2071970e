"""Bodies as drawn, and the arrays of nodes and springs made of them."""
