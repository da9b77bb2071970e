"""Keys of kernels that are made on the machine of the user say what is written, and no more."""

from functools import partial

import pytest

from tissuec.autodiff.graph import Graph
from tissuec.compiled.generated import _described
from tissuec.compiled.loops.points import force_loop
from tissuec.forces.point_kernels import written
from tissuec.forces.solids.solid_point import SolidKind, traced_point
from tissuec.laws.solid.invariants import NeoHookean, Yeoh


def key_of(law, *, nodes=8, **more):
    """Return the key of the forces of elements of a law."""
    kind = SolidKind((law, law), 0, 0, is_yielding=False, is_viscous=False, **more)
    return _described(partial(written, force_loop, traced_point, kind, nodes, 8))


def test_equal_content_has_equal_keys_whichever_parts_are_one_object():
    volume = "".join(["quad", "ratic"])  # another object than the literal
    one, other = NeoHookean(volume="quadratic"), NeoHookean(volume=volume)
    assert one.volume is not other.volume
    assert key_of(one) is not None
    assert key_of(one) == key_of(other)
    assert _described(partial(print, (one, one))) == _described(partial(print, (one, other)))


def test_different_content_has_different_keys():
    keys = [
        key_of(NeoHookean()), key_of(NeoHookean(volume="quadratic")), key_of(Yeoh(0.6, 1.8)),
        key_of(Yeoh(0.6, 1.9)), key_of(NeoHookean(), nodes=4),
        key_of(NeoHookean(), constants=1),
    ]  # fmt: skip
    assert len(set(keys)) == len(keys)


def _cycle():
    found = []
    found.append(found)
    return found


def _deep():
    found = ()
    for _ in range(100_000):
        found = (found,)
    return found


def _traced():
    return Graph().input("x")


@pytest.mark.parametrize("make", [_cycle, _deep, _traced, Graph])
def test_what_has_no_fixed_content_has_no_key(make):
    """Graphs grow as derivatives are asked for; kernels are then found by their text."""
    assert _described(partial(print, make())) is None
