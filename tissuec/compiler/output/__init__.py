"""The output block: what a run records, and how."""
