"""Statistics of fields as measures: ``largest(von Mises stress of A)``."""

from collections.abc import Iterator, Sequence

from msgspec import Struct

from tissuec.core.units import Dimension
from tissuec.model.network import Floats
from tissuec.results.fields import FIELDS, FrameField
from tissuec.results.fields.motion import OF_MOTION
from tissuec.script.measures import Subject
from tissuec.script.measures.snapshot import Snapshot
from tissuec.script.measures.statistics import PERCENTILE, form_of, statistic_of

#: Needs beside those of a field, by what has a number.
_NEEDS = {"cell": ("cells",)}
_OF_POINTS = ("whole elements",)


def names_of_fields() -> Iterator[str]:
    """Yield the names of all fields of which there are statistics."""
    yield from sorted({*FIELDS, *OF_MOTION})


def field_called(key: str) -> str:
    """Return the name of a field by a key of names; "" without one."""
    return key if key in OF_MOTION else FIELDS.called(key)


def field_named(name: str) -> type[FrameField]:
    """Return a field by its name."""
    return OF_MOTION[name] if name in OF_MOTION else FIELDS[name]


class FieldStatistic(Struct, frozen=True):
    """A statistic of a field, with the attributes and methods of a measure.

    Attributes:
        statistic: Of ``STATISTICS``.
        name: Of the field.
        share: Of a percentile.
    """

    statistic: str
    name: str
    share: float = 0.0

    subjects = 1

    @property
    def field(self) -> type[FrameField]:
        """Return the field."""
        return field_named(self.name)

    @property
    def form(self) -> str:
        """Return how it is written."""
        return form_of(self.statistic, self.name).replace("95 %", self._part)

    @property
    def title(self) -> str:
        """Return its name in logs, which precedes that of its subject."""
        if self.statistic == PERCENTILE:
            return f"percentile {self._part} of {self.name}"
        return f"{self.statistic} {self.name}"

    @property
    def _part(self) -> str:
        return f"{100.0 * self.share:.12g} %"

    @property
    def dimension(self) -> Dimension:
        """Return the dimension of the field."""
        return self.field.dimension

    @property
    def takes(self) -> str:
        """Return the kind of its subject, "springs" or "nodes"."""
        return "springs" if self.field.at == "spring" else "nodes"

    @property
    def needs(self) -> tuple[str, ...]:
        """Return the requirements on its subject."""
        more = _OF_POINTS if self.field.of_points else _NEEDS.get(self.field.at, ())
        return (*self.field.needs, *more)

    @property
    def of_contact(self) -> bool:
        """Return whether contact has to be on."""
        return "faces" in self.field.needs

    def columns(self, subjects: Sequence[Subject], snapshot: Snapshot) -> tuple[str, ...]:
        """Return the name of the only column."""
        return ("value",)

    def sample(self, subjects: Sequence[Subject], snapshot: Snapshot) -> Floats:
        """Return the values in SI units, shape (…, 1)."""
        numbers, weights = self.field.of(subjects[0], snapshot)
        return statistic_of(self.statistic, numbers, weights, self.share)[..., None]

    def value(self, sample: Floats) -> Floats:
        """Return the number that conditions compare, shape (…)."""
        return sample[..., 0]
