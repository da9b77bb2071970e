"""The fields of a leg as compiled code calls them, and with their present numbers."""

import numpy as np

from tissuec.compiled.calls import kernel_address
from tissuec.compiled.record_tables import RecordTable
from tissuec.forces import Field, acts_of
from tissuec.forces.derivatives import with_numbers
from tissuec.kernels.derivative_records import ActingFields, Values
from tissuec.learn.derivatives.event_schedule import Leg
from tissuec.learn.parameters.fields import Fields, derivatives_of, numbers
from tissuec.model.network import Floats


def present_fields(leg: Leg, values: Values) -> dict[str, Field]:
    """Return the fields of a leg with their numbers, by name.

    Args:
        leg: The leg.
        values: The numbers of this leg.
    """
    found: dict[str, Field] = {}
    start = 0
    for name, field in leg.fields.items():
        columns, stop = derivatives_of(field).columns, start + len(numbers(field))
        found[name] = with_numbers(field, columns, values.fields[start:stop])
        start = stop
    return found


def acting_fields(leg: Leg, fields: Fields, x: Floats) -> ActingFields:
    """Return the fields of a leg for compiled code.

    Args:
        leg: The leg, without knots of what fields follow in between.
        fields: As ``present_fields`` returns them.
        x: Positions from which nodes move by no more than the reach of a field [m], shape
            (3 node,).
    """
    place = np.arange(leg.network.node_count, dtype=np.int64)
    tables: list[RecordTable] = []
    calls: list[tuple[int, int, int]] = []
    counts = [0]
    for field in fields.values():
        acts = acts_of(field.changes, leg.start, leg.stop)
        table = RecordTable(field.table(place, acts, x.reshape(-1, 3)))
        _, back, forward = derivatives_of(field)
        loops = field.kernel, back, forward
        force, backwards, forwards = (kernel_address(loop, table) for loop in loops)
        calls.append((force, backwards, forwards))
        tables.append(table)
        counts.append(len(numbers(field)))
    addresses = np.array(calls, dtype=np.int64).reshape(-1, 3).T
    return ActingFields(
        *(np.ascontiguousarray(part) for part in addresses),
        table=np.array([table.address for table in tables], dtype=np.int64),
        first=np.cumsum(counts),
        weight=np.zeros(3 * len(place) if tables else 0),
        power=np.zeros(2),
        kept=tuple(tables),
    )
