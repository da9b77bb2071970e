"""Runs that are stepped from Python: examined, acted on, saved and recorded as a script."""
