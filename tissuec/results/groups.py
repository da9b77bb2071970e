"""Sets and regions in a result file: the names of nodes and springs."""

from collections.abc import Sequence

from tissuec.results import access
from tissuec.results.access import ResultGroup
from tissuec.results.recording import NamedGroup
from tissuec.results.schema import REGIONS, SETS
from tissuec.results.store import Store, member_name


def write_groups(store: Store, groups: Sequence[NamedGroup]) -> None:
    """Write sets, and regions under the names of their bodies."""
    for number, group in enumerate(groups):
        title = f"{group.name} of {group.body}" if group.body else group.name
        name, body = member_name(group.name), member_name(group.body)
        dataset = REGIONS["{body}/{name}"] if group.body else SETS["{name}"]
        dataset = dataset.of(what=group.what, title=title, name=name, body=body)
        store.array(dataset, group.indices)
        attributes = {key: getattr(group, key) for key in ("name", "what", "body")}
        store.label(dataset.path, **attributes, number=number)  # the place in the scene's order


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
        if place.path in file:
            visit(access.group(file, place.path))
    return tuple(found[number] for number in sorted(found))
