"""What can be wrong with a result file."""

from tissuec.core.errors import TissueError


class ResultError(TissueError):
    """A result file cannot be written, read or resumed; the message names it and says why."""
