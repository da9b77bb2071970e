"""Accuracy of positions, compared with the tolerance of the run."""

from collections.abc import Mapping
from math import inf
from typing import Any, Self

from msgspec import Struct


class Promise(Struct, frozen=True):
    """Whether positions are as accurate as the tolerance asks for.

    Attributes:
        state: "kept", "broken", "unknown" or "not checked".
        since: From when on it is broken or unknown [s]; None otherwise.
        error: Estimated error, relative to the largest displacement; None if not estimated.
        tolerance: What was promised; infinite where nothing was.
        reason: Why it is unknown or was not checked; what helps if it is broken.
        seconds: Wall time that the check took after the run [s].
        method: Of the companion run that checked it; "" without one.
        differs: Whether that is of another kind than all methods of the run.
        least: What the error is relative to [m] if the net moves less than a millionth of its
            size; None otherwise.
    """

    state: str
    since: float | None = None
    error: float | None = None
    tolerance: float = inf
    reason: str = ""
    seconds: float = 0.0
    method: str = ""
    differs: bool = False
    least: float | None = None

    @classmethod
    def of(cls, manifest: Mapping[str, Any]) -> Self:
        """Return the accuracy in the manifest of a result."""
        if (written := manifest.get("promise")) is not None:
            tolerance = inf if written["tolerance"] is None else float(written["tolerance"])
            entries: dict[str, Any] = {**written, "tolerance": tolerance}
            return cls(**entries)
        return cls("not checked")

    def __str__(self) -> str:
        return self.state if self.since is None else f"{self.state} from {self.since:g} s"
