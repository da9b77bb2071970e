"""A page with a slider for each property of a vocabulary, and what its rules make of them."""
