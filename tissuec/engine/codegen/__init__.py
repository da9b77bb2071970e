"""Writes the shipped kernels: ``python -m tissuec.engine.codegen``. It needs Numba."""
