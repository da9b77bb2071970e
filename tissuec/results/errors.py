"""Errors of result files."""

from tissuec.core.errors import TissueError


class ResultError(TissueError):
    """A result file cannot be written, read or resumed; the message names it and says why."""


class PlaceError(ResultError):
    """A result cannot stand, or be gone on with, where it was asked for; nothing has begun."""
