"""Translates kernels for ``compiled``: ``python -m tissuec.engine.codegen``. It needs Numba."""
