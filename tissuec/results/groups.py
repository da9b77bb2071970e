"""Sets and regions in a result file: the names of nodes and springs."""

from collections.abc import Sequence

from tissuec.results import access
from tissuec.results.access import ResultGroup
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
        attributes = {key: getattr(group, key) for key in ("name", "what", "body")}
        store.label(path, **attributes, number=number)  # the place in the scene's order


def read_groups(file: ResultGroup) -> tuple[NamedGroup, ...]:
    """Return all sets and regions, in the order of the scene."""
    found: dict[int, NamedGroup] = {}

    def visit(parent: ResultGroup) -> None:
        for member in map(parent.member, parent):
            if isinstance(member, ResultGroup):
                visit(member)
                continue
            name, what, body = (
                access.attribute(member, key, str) for key in ("name", "what", "body")
            )
            indices = member.whole()
            found[access.attribute(member, "number", int)] = NamedGroup(
                name, what, indices, body
            )

    for place in (SETS, REGIONS):
        if place in file:
            visit(access.group(file, place))
    return tuple(found[number] for number in sorted(found))
