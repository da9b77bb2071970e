"""Types of the part of llvmlite that tissuec uses; llvmlite itself ships none."""

__version__: str
