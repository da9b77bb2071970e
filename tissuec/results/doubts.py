"""Doubts: what a run found that makes its numbers doubtful."""

from collections.abc import Iterable, Mapping
from typing import Any

from msgspec import Struct, convert

from tissuec.core.errors import counted
from tissuec.core.units import TIME, show


class Doubt(Struct, frozen=True):
    """A finding that makes numbers of a run doubtful from some time on.

    Attributes:
        kind: A few words that are the same in all runs, such as "inside out".
        subject: What it concerns, such as "block" or "needle in block".
        what: A clause with what is wrong, such as "cells of block are inside out".
        time: When it was seen first [s]; of contacts, when the force was largest.
        where: Place where it was seen first, such as "at node 63 of block".
        most: How many there were at most.
        last: How many there were when the run was looked at last.
        unit: Noun for one of them, such as "cell".
        remedy: How to avoid it.
        place: ``file:line`` of the sentence that is concerned.
    """

    kind: str
    subject: str
    what: str
    time: float
    where: str
    most: int
    last: int
    unit: str
    remedy: str
    place: str

    def __str__(self) -> str:
        most = counted(self.most, self.unit)
        number = most if self.most == self.last else f"up to {most}, {self.last} at the end"
        seen = f"first at {show(self.time, TIME)} {self.where}".rstrip()
        return f"{self.what} ({number}, {seen}): {self.remedy} ({self.place})"


def doubts_of(manifest: Mapping[str, Any]) -> tuple[Doubt, ...]:
    """Return the doubts in the manifest of a result; none of results without the entry."""
    return tuple(convert(written, Doubt) for written in manifest.get("doubts", ()))


def kinds(doubts: Iterable[Doubt]) -> str:
    """Return the kinds of doubts, each once: "inside out, tool in tissue"."""
    return ", ".join(dict.fromkeys(doubt.kind for doubt in doubts))
