"""Result files: one HDF5 file that ParaView, H5MD readers and plain h5py all open.

Only this package, and what reads measured data, imports h5py; ``recording``, ``journal`` and
``mesh`` do without it.
"""

from tissuec.core.errors import TissueError

#: Precisions in which frames are stored.
SINGLE = "single"
PRECISIONS = {SINGLE: "24 binary digits", "double": "53 binary digits"}


class ResultError(TissueError):
    """A result file cannot be written, read or resumed; the message names it and says why."""


class ForeignFileError(ResultError):
    """A file is HDF5, but not a result."""


class PlaceError(ResultError):
    """A result cannot be written or resumed at its place; nothing has begun."""
