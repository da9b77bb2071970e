"""Errors of result files."""

from tissuec.core.errors import TissueError


class ResultError(TissueError):
    """A result file cannot be written, read or resumed; the message names it and says why."""


class ForeignFileError(ResultError):
    """A file is HDF5, but not a result."""


class PlaceError(ResultError):
    """A result cannot be written or resumed at its place; nothing has begun."""
