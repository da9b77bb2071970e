"""A page with a slider for each property of a vocabulary, and the results of its rules."""
