"""Translate all kernels anew: ``python -m tissuec.building``."""

from tissuec.building.exporting import export

if __name__ == "__main__":
    for path, size in export():
        print(f"{path.name}: {size / 1e3:.0f} kB")
