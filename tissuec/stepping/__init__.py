"""Runs that are stepped from Python: looked at, acted on, saved and recorded as a script."""
