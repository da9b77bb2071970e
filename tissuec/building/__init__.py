"""Translates kernels for ``compiled``: ``python -m tissuec.building``. It needs Numba."""

import os

# For any processor, and without optimisation: that is left to those who load what is shipped.
os.environ |= {"NUMBA_OPT": "0", "NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
