"""Numbers of ``force`` blocks as plain facts: for explanations, results and comparisons."""

from collections.abc import Mapping
from typing import Any

from msgspec import Struct, convert

from tissuec.core.data import as_data
from tissuec.core.units import Dimension, show
from tissuec.scene.model import WrittenForce
from tissuec.scene.reading import schema

WRITTEN, DEFAULT = "written", "default"


class ForceEntry(Struct, frozen=True):
    """An entry of a ``force`` block.

    Attributes:
        value: In SI units; several for vectors, text for words, None without a value.
        dimension: Of numbers; None for others.
        how: ``written``, or ``default`` where nothing is written.
        place: ``file:line`` of the entry, or of the block.
        text: As it is written; empty for a default.
    """

    value: Any
    dimension: Dimension | None
    how: str
    place: str
    text: str

    @property
    def shown(self) -> str:
        """Return the value with its unit."""
        if isinstance(self.value, float) and self.dimension is not None:
            return show(self.value, self.dimension, digits=4)
        return "none" if self.value is None else str(self.value)


class ForceNumbers(Struct, frozen=True):
    """What a ``force`` block says.

    Attributes:
        kind: The kind of force.
        acts_on: The set or body.
        place: ``file:line`` of the block.
        entries: By name in the language.
    """

    kind: str
    acts_on: str
    place: str
    entries: dict[str, ForceEntry]


def numbers_of(forces: Mapping[str, WrittenForce]) -> dict[str, ForceNumbers]:
    """Return the numbers of ``force`` blocks by name."""
    return {force.name: _numbers(force) for force in forces.values()}


def _numbers(force: WrittenForce) -> ForceNumbers:
    entries: dict[str, ForceEntry] = {}
    for name, entry in schema.entries_of(type(force.entries)).items():
        value, place = as_data(getattr(force.entries, entry.field)), force.places.get(name)
        dimension = getattr(entry.kind, "dimension", None)
        entries[name] = (
            ForceEntry(value, dimension, DEFAULT, force.span.place, "")
            if place is None
            else ForceEntry(value, dimension, WRITTEN, place.place, place.one_line)
        )
    return ForceNumbers(force.kind, force.target.text, force.span.place, entries)


def numbers_in(manifest: Mapping[str, Any]) -> dict[str, ForceNumbers] | None:
    """Return the numbers of the ``force`` blocks of a result; None if it lacks them."""
    written = manifest.get("forces")
    return None if written is None else convert(written, dict[str, ForceNumbers])
