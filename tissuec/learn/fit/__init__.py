"""The fit: problem, search, identifiability and outcome."""
