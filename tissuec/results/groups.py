"""Sets and regions in a result file: which nodes or springs have which name."""

from collections.abc import Sequence

import h5py

from tissuec.results import access
from tissuec.results.recording import NamedGroup
from tissuec.results.store import Store, member_name

SETS = "/tissuec/sets"
REGIONS = "/tissuec/regions"


def write_groups(store: Store, groups: Sequence[NamedGroup]) -> None:
    """Write sets, and regions under the names of their bodies."""
    for number, group in enumerate(groups):
        name = member_name(group.name)
        path = f"{REGIONS}/{member_name(group.body)}/{name}" if group.body else f"{SETS}/{name}"
        of = f" of {group.body}" if group.body else ""
        text = f"network numbers of the {group.what} of: {group.name}{of}"
        store.array(path, group.indices, text, compress=True)
        attributes = access.dataset(store.file, path).attrs
        for key in ("name", "what", "body"):
            attributes[key] = getattr(group, key)
        attributes["number"] = number  # the place in the scene's order


def read_groups(file: h5py.File) -> tuple[NamedGroup, ...]:
    """Return all sets and regions, in the order of the scene."""
    found: dict[int, NamedGroup] = {}

    def visit(_: str, member: h5py.Dataset | h5py.Group) -> None:
        if isinstance(member, h5py.Dataset):
            name, what, body = (
                str(access.attribute(member, key)) for key in ("name", "what", "body")
            )
            found[int(access.attribute(member, "number"))] = NamedGroup(
                name, what, member[:], body
            )

    for place in (SETS, REGIONS):
        if place in file:
            access.group(file, place).visititems(visit)
    return tuple(found[number] for number in sorted(found))
