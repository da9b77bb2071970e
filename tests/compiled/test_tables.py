"""Records in the memory of compiled code: what is read there is what was put in."""

import numba
import numpy as np
import pytest

import tissuec.compiled.numba_types  # noqa: F401  # how Numba understands tables
from tissuec.compiled.record_tables import RecordTable, aligned_zeros, layout
from tissuec.kernels import records

NUMBERS = {float: 2.5, int: -3, bool: True}


def filled(record, rng):
    """Return a record of random arrays, each of another shape, and numbers."""
    values = {}
    for name, (_, kind, dtype, axes, _) in layout(record)[0].items():
        if dtype is not None:
            values[name] = rng.integers(1, 99, rng.integers(1, 4, axes)).astype(dtype)
        elif kind in NUMBERS:
            values[name] = NUMBERS[kind]
        elif kind is object:  # what only Python reads
            values[name] = ()
        else:
            values[name] = filled(kind, rng)
    return record(**values)


def total(value):
    """Return a number that tells arrays and records of other numbers and shapes apart."""
    if isinstance(value, tuple):
        return sum(total(each) for each in value)
    if isinstance(value, np.ndarray):
        return float(value.flat[0]) + 1000.0 * value.shape[0] + value.strides[0]
    return float(value)


def reader(record, path):
    """Return source that adds up what ``total`` does, in compiled code."""
    terms = []
    for name, (_, kind, dtype, axes, _) in layout(record)[0].items():
        here = f"{path}.{name}"
        if dtype is not None:
            first = ", ".join("0" * axes)
            terms.append(f"{here}[{first}] + 1000.0 * {here}.shape[0] + {here}.strides[0]")
        elif kind in NUMBERS:
            terms.append(f"1.0 * {here}")
        else:
            terms += reader(kind, here)
    return terms


@pytest.mark.parametrize("record", [records.ContactTable, records.Work])
def test_compiled_code_reads_what_a_record_holds(record):
    lines = "".join(f"    found += {term}\n" for term in reader(record, "record"))
    names = {}
    exec(f"def read(record):\n    found = 0.0\n{lines}    return found\n", names)
    made = filled(record, np.random.default_rng(3))
    assert numba.njit(names["read"])(RecordTable(made)) == total(made)


def test_compiled_code_writes_into_the_arrays_of_a_record():
    made = filled(records.Buffer, np.random.default_rng(4))

    @numba.njit
    def write(buffer):
        buffer.position[0, 0] = 7.0

    write(RecordTable(made))
    assert made.position[0, 0] == 7.0


@pytest.mark.parametrize(
    "wrong",
    [np.zeros(3, dtype=np.float32), np.zeros((3, 3)), np.zeros(6)[::2]],
    ids=["numbers", "axes", "gaps"],
)
def test_an_array_that_is_not_as_its_record_says_is_refused(wrong):
    made = filled(records.Buffer, np.random.default_rng(5))
    with pytest.raises(TypeError, match=r"Buffer\.time is no contiguous array"):
        RecordTable(made._replace(time=wrong))


def test_what_a_scene_has_nothing_of_is_none():
    made = filled(records.Net, np.random.default_rng(6))._replace(touches=None)

    @numba.njit
    def read(net):
        return net.internal.slot.sum() + net.drag.sum()

    assert read(RecordTable(made)) == made.internal.slot.sum() + made.drag.sum()


def test_a_table_may_stand_for_a_record_within_another():
    made = filled(records.Work, np.random.default_rng(7))

    @numba.njit
    def read(work):
        return work.tableau.for_v.sum() + work.tableau.result + work.zero.sum()

    within = made._replace(tableau=RecordTable(made.tableau))
    table = RecordTable(within)
    assert read(table) == read(RecordTable(made))
    assert table.tableau.result == made.tableau.result


def test_aligned_zeros_begin_where_a_line_of_the_cache_does():
    for size in range(1, 40):
        made = aligned_zeros(2, size)
        assert made.shape == (2, size)
        assert not made.any()
        assert made.ctypes.data % 64 == 0
        RecordTable(filled(records.Buffer, np.random.default_rng(7))._replace(position=made))
