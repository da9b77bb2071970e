"""Files contain the datasets that are declared, and all of these."""

import re

import h5py
import numpy as np
import pytest

import tissuec
from tests.results.cut_block import cut_block
from tissuec.core.source import Source
from tissuec.engine.execution.recorder import wishes
from tissuec.pipeline import compile_request
from tissuec.results.datasets import FLOAT, TEXT
from tissuec.results.recording import LogChannel
from tissuec.results.schema import GROUPS, LOGS
from tissuec.results.tables import datasets_of
from tissuec.results.writer import ResultWriter
from tissuec.scene.request import Request

DECLARED = [one for group in GROUPS for one in group.values()]
SPRINGS = """language 1
tissue soft {
  spring constant = 5 N/m; viscosity = 20 mN*s/m; mass = 0.1 g
  relaxing constant = 1 N/m; relaxation time = 10 ms
}
tissue silk {
  spring law is tension only; spring constant = 50 N/m; viscosity = 30 mN*s/m; mass = 20 mg
}
body cube {
  mesh is lattice {
    kind is braced cubes; cell = 1 cm; box from (0, 0, 0) mm to (20, 10, 10) mm
  }
  tissue is soft; interface is mean; region half where x > 9 mm { tissue is soft }
}
body cyst {
  mesh is sphere { centre = (10, 5, 20) mm; radius = 5 mm; subdivisions = 1 }; tissue is soft
}
body sling {
  mesh is thread {
    centre = (40, 0, 0) mm; normal = (1, 0, 0); radius = 4 mm; pieces = 8; thickness = 1 mm
  }
  tissue is silk
}
set low = nodes of cyst where z < 16 mm
set left = nodes of cube where x < 1 mm
set edge = springs of cube where x > 19 mm and y < 1 mm
joint fibres { springs from low to cube; reach = 9 mm; tissue is silk }
tool finger { kind is probe; radius = 2 mm; centre = (10, 5, 40) mm }
environment { gravity = (0, 0, 0) m/s^2; contact is tools only; contact stiffness = 100 N/m }
simulate { duration = 20 ms; tolerance = 1e-2 }
script {
  at 0 s: { fix left; preserve volume of cube with 10 kPa }
  at 11 ms: cut edge
}
output {
  trajectory with [pressure, spring constant] every 5 ms; surface of cyst every 10 ms
  force of left every 5 ms; energy every 5 ms
}
"""
ELEMENTS = """language 1
tissue gel {
  Young's modulus = 20 kPa; Poisson's ratio = 0.45; density = 1000 kg/m^3
  retardation time = 5 ms; toughness = 30 J/m^2; fibre modulus = 40 kPa
}
body strip {
  mesh is lattice { cell = 4 mm; box from (0, 0, 0) mm to (8, 4, 8) mm }
  tissue is gel; rupture is allowed; fibres = (1, 0, 0); second fibres = (0, 1, 0)
}
set low = nodes of strip where z < 0.1 mm
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix low }
simulate { duration = 1 ms }
output { trajectory every 1 ms }
"""


def pattern(text, places="(.*)"):
    """Return what matches a text with names in its places."""
    return re.compile(re.sub(r"\\\{\w+\\\}", places, re.escape(text)), re.DOTALL)


def differences(found, declared):
    """Yield how a dataset differs from its declaration."""
    kind, axes = declared.kind, declared.axes
    if kind == TEXT:
        if found.dtype.kind != ("O" if axes else "S"):
            yield "no text"
    elif kind and found.dtype.name not in (
        ("float32", "float64") if kind == FLOAT else (np.dtype(kind).name,)
    ):
        yield f"{found.dtype} instead of {kind}"
    if axes and axes[-1] != "…" and len(axes) != found.ndim:
        yield f"shape {found.shape} instead of {axes}"
    if any(
        isinstance(one, int) and one != n for one, n in zip(axes, found.shape, strict=False)
    ):
        yield f"shape {found.shape} instead of {axes}"
    for name, wanted in (("unit", declared.unit), ("description", declared.text)):
        written = found.attrs.get(name)
        if written is not None and not pattern(wanted).fullmatch(written):
            yield f"{name} {written!r} instead of {wanted!r}"


def declarations(path):
    """Return the declarations that a path fits, best first: with fewest names."""
    fitting = [one for one in DECLARED if pattern(one.path, "([^/]+)").fullmatch(path)]
    return sorted(fitting, key=lambda one: one.path.count("{"))


def datasets(group, path=""):
    """Yield all datasets with their paths; one with two names comes twice."""
    for name, member in group.items():
        if isinstance(member, h5py.Group):
            yield from datasets(member, f"{path}/{name}")
        else:
            yield f"{path}/{name}", member


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    for name, scene in (("springs", SPRINGS), ("elements", ELEMENTS)):
        tissuec.run(scene, out=folder / f"{name}.vtkhdf").close()
    scene = compile_request(Request(Source("scene.tis", ELEMENTS)))[0]
    recording = wishes(scene.network, scene.plan)
    with ResultWriter(folder / "kept.vtkhdf", scene.network, recording, {}, ELEMENTS) as kept:
        kept.topology(np.ones(scene.network.entity_count, dtype=bool))
        kept.checkpoint({"time": 0.0})
    cut_block().saved(folder / "cut.vtkhdf", cut_block().recording(fields=()))
    names = ("springs.vtkhdf", "elements.vtkhdf", "kept.partial.vtkhdf", "cut.vtkhdf")
    return [folder / name for name in names]


def test_every_dataset_of_a_file_is_as_declared_and_every_declared_one_exists(files):
    found = set()
    for place in files:
        with h5py.File(place) as file:
            for path, dataset in datasets(file):
                fitting = declarations(path)
                assert fitting, f"{path} is not declared"
                assert not [*differences(dataset, fitting[0])], path
                found.add(fitting[0].path)
    assert {one.path for one in DECLARED} == found


def test_rows_that_come_during_a_run_are_declared_so(files):
    virtual = "/particles/all/"
    for place in files:
        with h5py.File(place) as file:
            for path, dataset in datasets(file):
                if not path.startswith(virtual):
                    grows = bool(dataset.maxshape) and dataset.maxshape[0] is None
                    assert bool(declarations(path)[0].chunk) == grows, path


def test_names_with_braces_are_names_and_no_places():
    """Rows and chunks may be set after the names."""
    channel = LogChannel("length of {a} {", ("{", "}"), "m", "The length of {a} {.")
    for one in datasets_of(LOGS, channel).values():
        again = one.of(kind="f4", chunk=7)
        assert "/length of {a} {/" in again.path
        assert again.text.endswith("The length of {a} {.")
