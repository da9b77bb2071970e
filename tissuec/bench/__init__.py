"""Measuring the engine on a scene: run time against error, beside other solvers."""
