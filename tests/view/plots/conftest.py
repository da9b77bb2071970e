"""Runs and texts that plots are drawn of."""

import json
from pathlib import Path

import pytest

from tests.study import tables_of_designs
from tissuec.core.source import Source
from tissuec.pipeline import compile_request, simulate
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request

pytest.importorskip("matplotlib")

STRIP = """language 1
use "tissues/muscle"
param cut time = 60 ms
body strip {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (30, 0, 0) mm; second edge = (0, 10, 0) mm
    columns = 7; rows = 3; diagonals is both
  }
  tissue is muscle
}
set left end = nodes of strip where x < 1 mm
set right end = nodes of strip where x > 29 mm
set some springs = springs of strip where x between 12 mm and 18 mm
environment { gravity = (0, 0, -9.81) m/s^2; damping = 2 mN*s/m }
script {
  at 0 s: fix left end
  from 0 s to 50 ms: move right end by (2, 1, 1) mm using smooth profile
  at cut time: cut strip along plane through (20, 0, 0) mm facing (1, 0, 0)
}
simulate { duration = 100 ms; integrator is dop853; tolerance = 1e-5 }
output {
  trajectory every 5 ms
  force of right end every 1 ms
  tension of some springs every 2 ms
  length of strip every 2 ms
  energy every 5 ms
  surface of strip every 5 ms { subdivisions = 1 }
}
"""
#: A bench of two solvers, as ``--json`` prints it.
BENCH = {
    "scene": "tube.tis", "ok": True, "nodes": 160, "springs": 610,
    "reference": {"method": "DOP853", "tolerance": 1e-12, "uncertainty": 1e-9},
    "points": [
        {"method": name, "ours": ours, "tolerance": 10.0**-k, "error": error * 10.0**-k,
         "seconds": seconds * k, "evaluations": 10 * k}
        for name, ours, error, seconds in (
            ("dop853", True, 0.5, 0.01), ("Other", False, 2.0, 0.1)
        )
        for k in (2, 4, 10)
    ],
}  # fmt: skip
STRESS = {
    "ok": False, "bad": 1, "methods": ["automatic", "dop853"],
    "signs": {"good": ["ok", "as promised"], "wrong": ["WRONG", "silently wrong"]},
    "verdicts": [
        {"axis": "stiffness", "value": value, "method": method, "kind": kind, "why": ""}
        for value, kinds in (("1e3", ("good", "good")), ("1e9", ("wrong", "good")))
        for method, kind in zip(("automatic", "dop853"), kinds, strict=True)
    ],
}  # fmt: skip

LAB = {
    "ok": True,
    "tissues": [
        {
            "tissue": "gel",
            "rows": [
                {"test": test, "quantity": quantity, "check": fine, "measured": fine,
                 "known": [{"low": low, "high": high, "source": "A"}]}
                for test, quantity, low, fine, high in (
                    ("tension", "Young's modulus", 4e3, 5e3, 6e3),
                    ("tearing", "breaking strain", 0.3, 0.4, 0.5),
                    ("tearing", "strength", 1.5e3, 2e3, 2.5e3),
                )
            ],
            "curves": [
                {"mode": "tension", "place": [0.1, 0.2, 0.4], "value": [500.0, 1e3, 2e3],
                 "check": [500.0, 1e3, 1.8e3],
                 "known": [{"places": [0.1, 0.3], "low": [400.0, 1e3], "high": [600.0, 2e3]}]},
                {"mode": "compression", "place": [0.05, 0.1], "value": [300.0, 600.0],
                 "check": [None, None],
                 "known": [{"places": [0.1], "low": [400.0], "high": [700.0]}]},
                {"mode": "relaxation", "place": [1.0], "value": [0.5], "check": [0.5],
                 "known": []},
            ],
        }
    ],
}  # fmt: skip


def carry_out(text: str, path: Path, *overrides: str, companion: str = "off") -> Path:
    """Run a scene; return its result file."""
    request = Request(Source("strip.tis", text), overrides)
    compiled, _ = compile_request(request)
    return simulate(compiled, path, request=request, companion=companion).path


@pytest.fixture(scope="session")
def folder(tmp_path_factory) -> Path:
    """Return a folder with results, a scene and the JSON of benches; nobody changes them."""
    folder = tmp_path_factory.mktemp("plots")
    carry_out(STRIP, folder / "strip.vtkhdf", companion="inline")
    carry_out(STRIP, folder / "later.vtkhdf", "cut time=80 ms")
    (folder / "strip.tis").write_text(STRIP, encoding="utf-8")
    (folder / "bench.json").write_text(json.dumps(BENCH), encoding="utf-8")
    (folder / "lab.json").write_text(json.dumps(LAB), encoding="utf-8")
    (folder / "stress.json").write_text(json.dumps(STRESS), encoding="utf-8")
    for name in ("grid", "plane", "sample", "one_at_a_time", "refined", "indices"):
        getattr(tables_of_designs, name)().to_csv(folder / f"{name}.csv")
    return folder


@pytest.fixture
def strip(folder):
    """Return the result of the scene, open."""
    with Trajectory.open(folder / "strip.vtkhdf") as trajectory:
        yield trajectory


@pytest.fixture
def result(folder) -> Path:
    return folder / "strip.vtkhdf"


@pytest.fixture
def later(folder) -> Path:
    """Return the result of the same scene with a later cut."""
    return folder / "later.vtkhdf"
