"""What is computed once does not keep alive what it was computed of."""

import gc
import inspect
import pkgutil
import weakref
from functools import _lru_cache_wrapper, cached_property
from importlib import import_module
from types import SimpleNamespace
from typing import get_type_hints

import numpy as np
import pytest
from msgspec import Struct

import tissuec
from tissuec.core.keeping import kept_on_owner
from tissuec.core.structs import replace
from tissuec.forces.contact.contact import Contact
from tissuec.model.network import BodyPart, Network

SCENE = """language 1
tissue cord {{ spring constant = 40 N/m; viscosity = 0.1 N*s/m; mass = 10 mg }}
body ball {{
  mesh is sphere {{
    centre = (0, 0, 0) mm; radius = {radius} mm; subdivisions = 1; interior is none
  }}
  tissue is cord
}}
set top = nodes of ball where z > 1 mm
environment {{ gravity = (0, 0, 0) m/s^2; contact is everywhere; contact stiffness = 1 N/m }}
script {{ at 0 s: {{ preserve volume of ball with 10 kPa; push top with (0, 0, 1) mN }} }}
simulate {{ duration = 2 ms }}
output {{ trajectory every 1 ms; force of top every 1 ms; volume of ball every 1 ms }}
"""


class Owner:
    def __init__(self, number):
        self.number = number


def test_results_go_with_their_owner():
    @kept_on_owner(2)
    def doubled(owner, by):
        calls.append(by)
        return owner, owner.number * by  # which refers to the owner

    calls, owner = [], Owner(21)
    assert doubled(owner, 2)[1] == doubled(owner, 2)[1] == 42 and calls == [2]
    for by in (3, 4, 3, 2):
        doubled(owner, by)
    assert calls == [2, 3, 4, 2]  # only the last two are kept
    watched = weakref.ref(owner)
    del owner
    gc.collect()
    assert watched() is None


@pytest.mark.parametrize("runs", [False, True])
def test_scenes_that_are_dropped_leave_no_net(runs):
    kept = []
    for radius in range(5, 9):
        text = SCENE.format(radius=radius)
        compiled = tissuec.compile(text)
        kept += map(weakref.ref, (compiled.network.position, compiled.network.springs.ends))
        if runs:
            stepped = tissuec.start(text)
            kept.append(weakref.ref(stepped.network.position))
            stepped.step("1 ms")
            stepped.measure("force of top")
            stepped.measure("volume of ball")
            del stepped
            tissuec.run(text, companion="inline").close()
        del compiled
    gc.collect()
    assert not [one for one in kept if one() is not None]


def test_no_cache_of_a_module_holds_a_net():
    """Functions that keep results for the whole process take no nets, bodies or arrays."""
    heavy = (Network, BodyPart, Contact, np.ndarray)
    found = []
    for module in pkgutil.walk_packages(tissuec.__path__, "tissuec."):
        if module.name.endswith("__main__") or ".bench" in module.name:
            continue
        for name, value in vars(import_module(module.name)).items():
            if isinstance(value, _lru_cache_wrapper) and value.__module__ == module.name:
                function = inspect.unwrap(value)
                taken = {k: v for k, v in function.__annotations__.items() if k != "return"}
                given = SimpleNamespace(__annotations__=taken)
                hints = get_type_hints(given, vars(import_module(module.name)))
                if any(
                    inspect.isclass(kind) and issubclass(kind, heavy) for kind in hints.values()
                ):
                    found.append(f"{module.name}.{name}")
    assert not found


def test_a_struct_with_other_values_keeps_no_results():
    class Square(Struct, frozen=True, dict=True):
        side: float

        @cached_property
        def area(self):
            return self.side**2

    one = Square(2.0)
    assert one.area == 4.0 and replace(one, side=3.0).area == 9.0 and one.area == 4.0
