"""A quantity has one unit: on the page, in the report, on axes and in CSV."""

import csv
import io
import json
import re

import numpy as np
import pytest

from tests.every import every
from tests.view.plots.conftest import carry_out
from tissuec.core.scale import readable
from tissuec.core.units import parse_unit
from tissuec.results.export import table_rows, write_csv
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.page import render
from tissuec.view.plots import draw
from tissuec.view.report import page
from tissuec.view.report.content import ReportContent

#: Components below 1 of a unit whose resultants are above, and quantities of every kind.
SLING = """language 1
tissue gum { spring constant = 91 N/m; viscosity = 0.5 N*s/m; mass = 1 g }
body net { mesh is explicit; tissue is gum }
table nodes of net in mm with columns "id x y" { 1 0 0; 2 100 0 }
table springs of net with columns "a b" { 1 2 }
set wall = nodes of net in [1]
set hand = nodes of net in [2]
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix wall
  from 0 s to 0.3 s: move hand by (-20, 80, 0) mm using smooth profile
}
simulate { duration = 0.4 s; tolerance = 1e-5 }
output {
  trajectory every 20 ms
  position of hand every 10 ms; force of hand every 10 ms; length of net every 10 ms
  speed of hand every 10 ms; strain of net every 10 ms
  energy every 10 ms
}
"""


@pytest.fixture(scope="module")
def sling(tmp_path_factory):
    """Return the run of a spring that is pulled aside."""
    folder = tmp_path_factory.mktemp("sling")
    with Trajectory.open(carry_out(SLING, folder / "sling.vtkhdf")) as run:
        yield run


def _in_plots(run):
    """Return the units of all logs as the axes of plots have them; "" for plain numbers."""
    found = {}
    for name in run.logs:
        labels = {_unit(axes.get_ylabel()) for axes in draw("logs", run, log=name).axes}
        column = "" if len(run.logs[name].columns) == 1 else " along y"
        (axes,) = draw("x-y", run, x="time", y=name + column).axes
        (found[name],) = labels | {_unit(axes.get_ylabel())}
        # A part of the time changes nothing.
        (axes, *_) = draw("logs", run, log=name, start=0.0, stop=0.02).axes
        assert _unit(axes.get_ylabel()) == found[name]
    found["energies"] = _unit(draw("energies", run).axes[0].get_ylabel())
    found["time"] = _unit(draw("x-y", run, x="time", y="length of net").axes[0].get_xlabel())
    assert found["time"] == _unit(draw("logs", run, stop=0.02).axes[-1].get_xlabel())
    return found


def _unit(label):
    found = re.search(r"\[(.*)\]$", label)
    return found[1] if found else ""


def _in_page(run):
    film = json.loads(re.search(r'id="film">(.*?)</script>', render(run), re.DOTALL)[1])
    return {one["name"]: one["shown"][1] for one in film["curves"]} | {"time": film["clock"][1]}


def _in_report(run):
    rows = re.findall(
        r'<tr><th scope="row">([^<:]*)[^<]*</th>(?:<td>[^<]*</td>){3}<td>([^<]*)</td></tr>',
        page.logs(ReportContent(run)).body,
    )
    return {name: unit.replace("–", "") for name, unit in rows}


def _in_csv(run):
    stream = io.StringIO()
    write_csv(table_rows(run, [*run.logs, "energies"]), stream)
    heads = next(csv.reader(io.StringIO(stream.getvalue())))
    names = [*run.logs, "energies", "time"]
    return {
        next(name for name in names if head.startswith(name)): readable(_unit(head))
        for head in heads
    }


def test_a_quantity_has_one_unit_everywhere(sling, unplaced):
    plots = _in_plots(sling)
    assert plots["force of hand"] == "N" and plots["length of net"] == "mm"
    assert (
        np.abs(sling.logs["force of hand"].value).max()
        < 1.0
        < sling.logs["force of hand"].largest
    )
    assert _in_page(sling) == plots
    assert _in_csv(sling) == plots
    del plots["time"]
    assert _in_report(sling) == plots


def test_the_largest_number_is_between_1_and_1000(sling):
    for log in (*sling.logs.values(), sling.energies):
        if log.unit:
            assert 0.9995 <= log.scale.of(log.largest) < 999.5, log.name


@every("value", [0.0123, 1 / 3, 2.5e-7, 123456.789, 1e-30, 0.1 + 0.2, 7.0])
def test_numbers_of_csv_are_those_of_the_log(value):
    """Digits are shifted, not multiplied: dividing exactly gives back the same number."""
    from decimal import Decimal

    from tissuec.core.scale import scale_of

    for unit in ("N", "m^3", "J"):
        scale = scale_of(unit, [value])
        (text,) = scale.exactly([value])
        assert float(Decimal(str(text)).scaleb(scale.power)) == value
        size = parse_unit(scale.spelled).factor / parse_unit(unit).factor
        assert float(text) * size == pytest.approx(value, rel=1e-15)
