"""Measuring the engine: run time against error beside other solvers, and where it may fail."""
