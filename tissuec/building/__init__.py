"""Translates kernels for ``compiled``: ``python -m tissuec.building``. It needs Numba."""
