"""Logged quantities of a result file."""

from collections.abc import Iterator, Mapping
from functools import cached_property

from tissuec.core.errors import counted
from tissuec.network import Floats
from tissuec.results import access
from tissuec.results.access import Group
from tissuec.results.tables import read_channel, read_channels

MOST_NAMED = 6  # columns


class Log:
    """A logged quantity.

    Attributes:
        name: What the scene calls it.
        columns: What the numbers of a row are: axes or ids.
        unit: Their unit.
        description: One sentence.
    """

    def __init__(self, file: Group, path: str):
        channel = read_channel(file, path)
        self.name, self.columns = channel.name, channel.columns
        self.unit, self.description = channel.unit, channel.description
        self._group = access.group(file, path)

    @cached_property
    def time(self) -> Floats:
        """The moments [s], shape (moment,)."""
        return access.array(self._group, "time")

    @cached_property
    def value(self) -> Floats:
        """The rows [unit], shape (moment, column)."""
        return access.array(self._group, "value")

    def __repr__(self) -> str:
        columns = ", ".join(map(str, self.columns[:MOST_NAMED]))
        more = ", …" if len(self.columns) > MOST_NAMED else ""
        size = counted(len(access.dataset(self._group, "time")), "moment")
        return f'<log "{self.name}" [{self.unit}]: {size} of {columns}{more}>'


class Logs(Mapping[str, Log]):
    """All logs of a file by name, in the order of the scene."""

    def __init__(self, file: Group):
        self._file = file
        self._paths = read_channels(file)

    def __getitem__(self, name: str) -> Log:
        return Log(self._file, self._paths[name])

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)

    def __repr__(self) -> str:
        return "\n".join(map(repr, self.values())) or "<no logs>"
