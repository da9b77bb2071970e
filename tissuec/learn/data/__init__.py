"""Measured data: tables as text, results of runs, and H5MD files become series of numbers."""
