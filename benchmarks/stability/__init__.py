"""The stress test: scenes at the ends of what can be written, and whether a run says so."""
