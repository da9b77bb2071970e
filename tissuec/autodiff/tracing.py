"""Errors of traced functions, with the lines at which they arise."""

import os
import sys
from collections.abc import Callable
from pathlib import Path
from types import CodeType, FrameType
from typing import Any, TypeVar

from tissuec.autodiff.graph import Graph, Number, Operation, TracingError

_HERE = str(Path(__file__).parent)
_NUMPY = f"{os.sep}numpy{os.sep}"
_Result = TypeVar("_Result")


def traced(function: Callable[..., Any], trace: Callable[[], _Result]) -> _Result:
    """Return the result of tracing a function.

    Args:
        trace: Calls it.

    Raises:
        TracingError: It does what cannot be traced, or fails; with its file and line.
    """
    try:
        return trace()
    except Exception as error:
        text = str(error)
        if not isinstance(error, TracingError):
            text = f"it fails with {type(error).__name__}: {error}"
        place, step = place_of(function), error.__traceback__
        while step:
            if _is_own(code := step.tb_frame.f_code):
                place = f"{code.co_filename}:{step.tb_lineno}"
            step = step.tb_next
        raise TracingError(f"{place}: {text}") from error


def place_of(function: Callable[..., Any]) -> str:
    """Return the file and the line of a function, such as "bed.py:12"."""
    code = getattr(function, "__code__", None)
    return f"{code.co_filename}:{code.co_firstlineno}" if code else repr(function)


def _is_own(code: CodeType) -> bool:
    """Return whether code is of a function that is traced, and not of what it calls."""
    return not code.co_filename.startswith(_HERE) and _NUMPY not in code.co_filename


class LocatedGraph(Graph):
    """A graph that knows the lines that have written its operations.

    Attributes:
        lines: File and line of each operation, as those of ``place_of``.
    """

    def __init__(self) -> None:
        super().__init__()
        self.lines: list[str] = []

    def record(self, operation: Operation) -> Number:
        """Return the result of an operation, as ``Graph`` does."""
        found = super().record(operation)
        if len(self.operations) > len(self.lines):
            frame: FrameType | None = sys._getframe(1)
            while frame and not _is_own(frame.f_code):
                frame = frame.f_back
            self.lines.append(f"{frame.f_code.co_filename}:{frame.f_lineno}" if frame else "")
        return found
