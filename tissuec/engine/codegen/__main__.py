"""Translate all kernels, or some bundles: ``python -m tissuec.engine.codegen [BUNDLE …]``."""

import os
import sys
import warnings


def main() -> None:
    """Write bundles, and print their sizes."""
    # For any processor, and without optimisation: that is left to those who load it. Numba
    # reads this when it is imported.
    os.environ |= {"NUMBA_OPT": "0", "NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    from tissuec.engine.codegen.contents import export

    warnings.filterwarnings("ignore", message="Cannot cache compiled function")
    for path, size in export(sys.argv[1:]):
        print(f"{path.name}: {size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
