"""Which fields the frames of a file contain, and the cells that some of them are about."""

import msgspec

from tissuec.results import access
from tissuec.results.access import ResultGroup
from tissuec.results.fields import FieldChannel, always_recorded
from tissuec.results.store import Store
from tissuec.results.volume_cells import VolumeCells

FIELDS = "/tissuec/recording/fields"
CELLS = "/tissuec/cells"


def write_channels_of_frames(store: Store, channels: tuple[FieldChannel, ...]) -> None:
    """Write the fields that frames contain, if a scene asks for some of them."""
    if channels != always_recorded():
        texts = [msgspec.json.encode(one).decode() for one in channels]
        store.texts(FIELDS, texts, "fields that frames contain, as JSON")


def read_channels_of_frames(file: ResultGroup) -> tuple[FieldChannel, ...]:
    """Return the fields that frames contain."""
    if FIELDS not in file:
        return tuple(one for one in always_recorded() if _holds(file, one))
    texts = access.texts(file, FIELDS)
    with access.reading(file.file, FIELDS):
        return tuple(msgspec.json.decode(text, type=FieldChannel) for text in texts)


def _holds(file: ResultGroup, channel: FieldChannel) -> bool:
    """Return whether a file without a list contains a field: one may be newer than the file."""
    group = "CellData" if channel.at in ("spring", "triangle") else "PointData"
    return f"VTKHDF/{group}/{channel.stored}" in file


def write_volume_cells(store: Store, cells: VolumeCells) -> None:
    """Write the cells of preserved volumes into a new file."""
    store.texts(f"{CELLS}/body", cells.bodies, "bodies whose volume may be preserved")
    store.array(f"{CELLS}/count", cells.counts, "number of cells of each body")
    store.array(f"{CELLS}/nodes", cells.pairs, "nodes, and the cells around them")


def read_volume_cells(file: ResultGroup) -> VolumeCells | None:
    """Return the cells that a file contains numbers of; None if there are none."""
    if CELLS not in file:
        return None
    group = access.group(file, CELLS)
    bodies = tuple(access.texts(group, "body"))
    return VolumeCells(bodies, access.array(group, "count"), access.array(group, "nodes"))
