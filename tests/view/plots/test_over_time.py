"""Curves over time show what the file holds."""

from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.colors import to_hex

from tests.view.plots.conftest import STRIP, carry_out
from tests.whole_runs import AfterAsking
from tissuec.core.errors import CompileError, TissueError
from tissuec.core.palette import SERIES
from tissuec.core.source import Source
from tissuec.engine.execution.recorder import Recorder, wishes
from tissuec.engine.execution.run import run
from tissuec.pipeline import compile_request, simulate
from tissuec.results.trajectory import Trajectory
from tissuec.results.writer import ResultWriter
from tissuec.scene.request import Request
from tissuec.view.plots import draw
from tissuec.view.plots.logs import AXES, LogsPlot
from tissuec.view.plots.over_time import Panel, TimeCurve, draw_panels
from tissuec.view.plots.page import new_sheet
from tissuec.view.plots.subjects import PlotSubject

pytestmark = pytest.mark.usefixtures("unplaced")


def lines_of(axes):
    """Return the curves with points by their names, without the marks of events."""
    lines = [line for line in axes.get_lines() if line.get_gid() != "event"]
    return {str(line.get_label()): line for line in lines if len(line.get_xdata())}


def data(line):
    return np.asarray(line.get_xdata(), float), np.asarray(line.get_ydata(), float)


def marks_of(axes):
    return sorted(
        {line.get_xdata()[0] for line in axes.get_lines() if line.get_gid() == "event"}
    )


# --- logs -------------------------------------------------------------------------------------


def test_a_force_has_its_components_and_its_magnitude(result, strip):
    log = strip.logs["force of right end"]
    (axes,) = draw("logs", result, log="Force of right end").axes
    assert axes.get_ylabel() == "force of right end [mN]"
    assert axes.get_xlabel() == "time [ms]"
    lines = lines_of(axes)
    assert set(lines) == {"magnitude", "x", "y", "z"}
    times, values = log.with_jumps()
    for column, name in enumerate("xyz"):
        time, value = data(lines[name])
        assert time == pytest.approx(1e3 * times)
        assert value == pytest.approx(1e3 * values[:, column])
    assert data(lines["magnitude"])[1] == pytest.approx(1e3 * np.linalg.norm(values, axis=1))
    assert len({str(lines[name]._dash_pattern) for name in "xyz"}) == 3  # without colours too
    assert marks_of(axes) == pytest.approx([60.0])
    assert [text.get_text() for text in axes.texts if text.get_gid() == "event"] == ["cut"]


def test_what_a_cut_changes_is_a_vertical_step_at_its_time(result, strip):
    """Springs that the blade severs pull until then, and not any more: no slope between."""
    log = strip.logs["tension of some springs"]
    (cut,) = (event.time for event in strip.events if event.kind == "cut")
    assert (log.time == cut).sum() == 1  # as many rows as ever
    (place,) = np.flatnonzero(log.jumps.time == cut)
    before, after = log.jumps.before[place], log.jumps.after[place]
    assert (after[before != after] == 0.0).all() and (before != after).any()
    (axes,) = draw("logs", result, log="tension of some springs").axes
    for name, reduced in (("largest", np.max), ("smallest", np.min)):
        time, value = data(lines_of(axes)[name])
        assert value[np.isclose(time, 1e3 * cut, rtol=1e-12)][:2] == pytest.approx(
            [1e3 * reduced(before), 1e3 * reduced(after)]
        )


def test_without_names_every_log_has_a_panel(result, strip):
    axes = draw("logs", result).axes
    labels = [one.get_ylabel().replace("\n", " ") for one in axes]
    assert labels == [
        "force of right end [mN]", "tension of some springs, 16 values [mN]",
        "length of strip [mm]",
    ]  # fmt: skip
    _, tension = strip.logs["tension of some springs"].with_jumps()
    lines = lines_of(axes[1])
    assert data(lines["largest"])[1] == pytest.approx(1e3 * tension.max(axis=1))
    assert data(lines["smallest"])[1] == pytest.approx(1e3 * tension.min(axis=1))
    assert len(axes[1].collections) == 1  # the band between


def test_a_window_of_time_is_cut_out(result):
    axes = draw("logs", result, log="force of right end", start=0.02, stop=0.05).axes[0]
    time = data(lines_of(axes)["x"])[0]  # in ms, for the last one is 50 ms
    assert axes.get_xlabel() == "time [ms]"
    assert (time[0], time[-1], len(time)) == pytest.approx((20.0, 50.0, 31))
    with pytest.raises(TissueError, match="runs from 0 s to 100 ms"):
        draw("logs", result, start=3.0)
    with pytest.raises(TissueError, match="start = 50 ms is after stop = 20 ms"):
        draw("logs", result, start=0.05, stop=0.02)


def test_several_runs_lie_over_one_another(result, later, strip):
    figure = draw("logs", result, later, log="force of right end")
    labels = [axes.get_ylabel().replace("\n", " ") for axes in figure.axes]
    assert labels == [
        f"force of right end {part} [mN]"
        for part in ("(magnitude)", "along x", "along y", "along z")
    ]
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["strip", "later"]
    with Trajectory.open(later) as other:
        logs = [run.logs["force of right end"].with_jumps()[1] for run in (strip, other)]
        values = [log[:, 2] for log in logs]
    first, second = (
        line for line in figure.axes[3].get_lines()
        if line.get_gid() != "event" and len(line.get_xdata())
    )  # fmt: skip
    for line, value, colour in zip((first, second), values, SERIES, strict=False):
        assert data(line)[1] == pytest.approx(1e3 * value)
        assert to_hex(line.get_color()) == colour
    assert marks_of(figure.axes[0]) == pytest.approx([60.0, 80.0])


def test_runs_of_the_same_name_are_told_apart(result, tmp_path):
    copy = tmp_path / "strip.vtkhdf"
    copy.write_bytes(result.read_bytes())
    figure = draw("logs", result, copy)
    texts = [text.get_text() for text in figure.legends[0].get_texts()]
    assert texts == [str(result), str(copy)]


def test_a_force_along_one_axis_says_so(tmp_path):
    text = """language 1
tissue cord { spring constant = 40 N/m; viscosity = 0.1 N*s/m; mass = 10 g }
body pair { mesh is explicit; tissue is cord }
table nodes of pair in mm with columns "id x" { 1 0; 2 11 }
table springs of pair in mm with columns "a b rest length" { 1 2 10 }
set wall = nodes of pair where id == 1
set bob = nodes of pair where id == 2
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix wall }
simulate { duration = 20 ms }
output { force of wall every 1 ms; position of bob every 1 ms }
"""
    path = carry_out(text, tmp_path / "pair.vtkhdf")
    force, place = draw("logs", path).axes
    assert force.get_ylabel() == "force of wall along x\n[mN]"
    assert place.get_ylabel() == "position of bob along x\n[mm]"


@pytest.mark.parametrize("small", [1e-6, 1e-2])
def test_a_component_that_is_not_there_is_left_out_and_named(small):
    time = np.linspace(0.0, 1.0, 9)
    value = np.stack([time, small * time, 0.5 * time], axis=1)
    log = SimpleNamespace(
        name="force of A",
        columns=AXES,
        time=time,
        value=value,
        largest=5.0,
        unit="N",
        with_jumps=lambda: (time, value),
    )
    run = PlotSubject("result", "run", SimpleNamespace(logs={"force of A": log}))
    ((panel,), notes) = LogsPlot(log=("force of A",)).panels([run])
    names = {curve.name for curve in panel.curves}
    said = "force of A: component y below 0.1 % of the largest"
    assert (said in notes) == ("y" not in names) == (small < 1e-3)
    assert {"magnitude", "x", "z"} <= names


def test_unknown_logs_and_none_at_all_are_errors_that_help(result, tmp_path):
    with pytest.raises(TissueError, match='did you mean "force of right end"'):
        draw("logs", result, log="force of rigth end")
    bare = STRIP[: STRIP.index("output {")] + "output { trajectory every 50 ms }\n"
    path = carry_out(bare, tmp_path / "bare.vtkhdf")
    with pytest.raises(TissueError, match="has no logs; it has 3 frames; write output"):
        draw("logs", path)
    with pytest.raises(TissueError, match="has no energies; write output"):
        draw("energies", path)
    text = STRIP.replace("  trajectory every 5 ms\n", "").replace("  surface of", "  # ")
    path = carry_out(text, tmp_path / "still.vtkhdf")
    for kind in ("paths", "frames"):
        with pytest.raises(TissueError, match="has no frames; write output"):
            draw(kind, path)
    with pytest.raises(TissueError, match="has no errors"):
        draw("errors", path)


# --- energies ---------------------------------------------------------------------------------


def test_the_stack_reaches_what_was_put_in(result, strip):
    figure = draw("energies", result)
    stack, drift = figure.axes
    times, rows = strip.energies.with_jumps()
    assert len(times) == len(strip.energies.time) + 2  # both sides of the cut
    value = dict(zip(strip.energies.columns, rows.T, strict=True))
    time, supply = data(lines_of(stack)["supplied"])
    assert time == pytest.approx(1e3 * times)
    gravity = value["gravity"] - value["gravity"].min()
    there = value["kinetic"] + value["elastic"] + gravity + value["dissipated"]
    put_in = there[0] + value["work"] + value["switched"]
    assert supply == pytest.approx(put_in * supply[-1] / put_in[-1])  # whatever the prefix
    names = [band.get_label() for band in stack.collections]
    assert names == ["elastic", "kinetic", "gravity", "dissipated"]
    top = stack.collections[-1].get_paths()[0].vertices[:, 1].max()
    # The ledger closes to 1e-5 of it, so the stack ends where the line runs.
    assert top == pytest.approx(supply.max(), rel=1e-4)
    legend = [text.get_text() for text in stack.get_legend().get_texts()]
    assert legend == ["supplied", *names[::-1]]  # as they lie, from above
    (line,) = lines_of(drift).values()
    moving = value["kinetic"] + value["elastic"]
    sizes = np.abs([moving, value["work"], value["dissipated"], value["switched"]]).max(axis=0)
    error = np.abs(there - put_in)[1:] / np.maximum.accumulate(sizes)[1:]
    assert data(line)[1][1:] == pytest.approx(error, rel=1e-3, abs=1e-13)
    assert drift.get_yscale() == "log"


def test_energies_have_lines_if_asked_and_for_several_runs(result, later):
    above, _ = draw("energies", result, lines=True).axes
    assert set(lines_of(above)) == {"elastic", "kinetic", "gravity", "dissipated", "supplied"}
    figure = draw("energies", result, later)
    labels = [axes.get_ylabel().replace("\n", " ") for axes in figure.axes]
    assert [label.partition(" [")[0] for label in labels] == [
        "elastic energy", "kinetic energy", "gravity energy", "energy dissipated",
        "energy supplied", "energy drift",
    ]  # fmt: skip


# --- paths ------------------------------------------------------------------------------------


def test_a_path_is_the_mean_and_the_range_of_displacements(result, strip):
    figure = draw("paths", result, of="nodes of strip where x > 29 mm and y > 4 mm")
    assert [axes.get_ylabel()[-4:] for axes in figure.axes] == ["[mm]"] * 3
    home = strip.network.position
    rows = np.flatnonzero((home[:, 0] > 0.029) & (home[:, 1] > 0.004))
    moved = 1e3 * (strip.position[:] - home)[:, rows]
    for axis, axes in enumerate(figure.axes):
        (line,) = lines_of(axes).values()
        assert data(line)[1] == pytest.approx(moved[:, :, axis].mean(axis=1), abs=1e-12)
        (band,) = axes.collections
        heights = band.get_paths()[0].vertices[:, 1]
        assert heights.max() == pytest.approx(moved[:, :, axis].max(), abs=1e-12)
        assert heights.min() == pytest.approx(moved[:, :, axis].min(), abs=1e-12)


def test_every_set_that_is_asked_for_is_its_own(result):
    """Two expressions, a name and a body: none of them is mistaken for another."""
    ends = ("nodes of strip where x > 29 mm", "nodes of strip where x < 1 mm")
    asked = (*ends, "strip", "RIGHT END")
    axes = draw("paths", result, of=asked).axes[0]
    ends = {name: data(line)[1][-1] for name, line in lines_of(axes).items()}
    assert ends[asked[0]] == pytest.approx(2.0, abs=1e-3)
    assert ends[asked[1]] == 0.0
    assert 0.1 < ends["strip"] < 1.9
    assert ends["RIGHT END"] == ends[asked[0]]


def test_without_names_what_moves_is_shown(result):
    figure = draw("paths", result)
    assert set(lines_of(figure.axes[0])) == {"right end", "strip"}  # the left end is fixed


def test_positions_instead_of_displacements(result, strip):
    axes = draw("paths", result, of="right end", places=True).axes[0]
    assert axes.get_ylabel() == "position of right end\nalong x [mm]"
    (line,) = lines_of(axes).values()
    assert data(line)[1][0] == pytest.approx(30.0)


def test_what_is_asked_of_wrongly_is_shown_with_its_place(result):
    for asked, code in (
        ("nodes of strip where x < 1 N", "TIS502"), ("[right end, rest]", "TIS301"),
        ("nodes of strip where x < -1 m", "TIS302"), ("springs of strip", "TIS314"),
        ("nodes of strip where", "TIS1"),
    ):  # fmt: skip
        with pytest.raises(CompileError) as error:
            draw("paths", result, of=asked)
        assert error.value.diagnostics[0].code.startswith(code), asked


@pytest.mark.parametrize("name", ["rigth end", "some springs", "a, b", ""])
def test_a_name_that_there_is_not_is_an_error_with_those_that_there_are(result, name):
    with pytest.raises(TissueError, match="left end, right end, strip; or write a set"):
        draw("paths", result, of=name)


def test_sets_are_known_by_what_the_result_holds_and_not_by_files_of_today(tmp_path):
    library = tmp_path / "library"
    library.mkdir()
    (library / "far.tis").write_text("language 1\nlet reach = 29 mm\n", encoding="utf-8")
    text = STRIP.replace('use "tissues/muscle"', 'use "tissues/muscle"\nuse "far"')
    text = text.replace("x > 29 mm", "x > reach")
    scene = tmp_path / "strip.tis"
    scene.write_text(text, encoding="utf-8")
    request = Request.file(scene)
    compiled, _ = compile_request(request)
    path = simulate(compiled, tmp_path / "far.vtkhdf", request=request).path
    (library / "far.tis").unlink()
    scene.unlink()
    axes = draw("paths", path, of="nodes of strip where x > reach").axes[0]
    assert data(next(iter(lines_of(axes).values())))[1][-1] == pytest.approx(2.0, abs=1e-3)


def test_a_net_that_is_drawn_otherwise_today_is_an_error(result, monkeypatch):
    text = STRIP.replace("(30, 0, 0) mm", "(31, 0, 0) mm")
    monkeypatch.setattr(Trajectory, "text", text)
    with pytest.raises(TissueError, match="the files give another net than the one in the run"):
        draw("paths", result, of="nodes of strip where x > 29 mm")
    assert draw("paths", result, of="right end")  # names are in the result


# --- errors -----------------------------------------------------------------------------------


def test_errors_are_those_of_the_file_below_what_is_allowed(result, strip):
    (axes,) = draw("errors", result).axes
    lines = lines_of(axes)
    assert set(lines) == {"estimated", "companion run", "allowed by 1e-05"}
    unit = {"µm": 1e6, "nm": 1e9}[axes.get_ylabel()[-3:-1]]
    assert data(lines["estimated"])[1] == pytest.approx(unit * strip.errors.value[:, 0])
    assert data(lines["companion run"])[1] == pytest.approx(unit * strip.companion.value[:, 0])
    moved = np.linalg.norm(strip.position[:] - strip.network.position, axis=2).max(axis=1)
    reach = np.maximum(np.maximum.accumulate(moved), 1e-6 * 0.03)
    assert data(lines["allowed by 1e-05"])[1] == pytest.approx(unit * 1e-5 * reach)


def test_a_long_head_stays_on_the_page(result, monkeypatch):
    changes = "rkn4, dop853 from 237 us on, esdirk43 from 0.6 s on, 1278 steps (compiled)"
    monkeypatch.setattr("tissuec.view.plots.overview.stepping", lambda manifest: changes)
    figure = draw("overview", result)
    head = figure._suptitle
    assert "1278" in head.get_text()
    assert head.get_window_extent().x1 <= figure.bbox.x1


# --- runs that did not end --------------------------------------------------------------------


def test_an_unfinished_run_is_drawn_as_far_as_it_goes_and_says_so(tmp_path):
    compiled, _ = compile_request(Request(Source("strip.tis", STRIP)))
    network, plan = compiled.network, compiled.plan
    manifest = {"scene": "strip.tis", "sources": {}, "overrides": [], "duration": 0.1}
    wanted = wishes(network, plan)
    with ResultWriter(tmp_path / "half.vtkhdf", network, wanted, manifest, STRIP) as writer:
        recorder = Recorder(network, plan, writer)
        outcome = run(network, plan, recorder, interrupt=AfterAsking(3))
        writer.close(outcome.message, False, {})
    path = next(tmp_path.glob("half*.vtkhdf"))
    with Trajectory.open(path) as half:
        last = half.logs["force of right end"].time[-1]
        assert not half.finished and 0.0 < last < 0.1
    for kind in ("overview", "logs", "frames", "energies"):
        figure = draw(kind, path)
        (said,) = (note for note in figure.notes if "unfinished" in note)
        assert f"{path.stem} is unfinished: until" in said and said.endswith("of 100 ms")
        shown = [text.get_text() for text in figure.texts]
        shown += [] if figure._supxlabel is None else [figure._supxlabel.get_text()]
        shown += [sub._supxlabel.get_text() for sub in figure.subfigs if sub._supxlabel]
        assert any(said in text for text in shown)


def test_numbers_that_are_none_are_told():
    time = np.linspace(0.0, 1.0, 5)
    value = np.array([0.0, 1.0, np.nan, 3.0, np.inf])
    with new_sheet(100.0, 60.0) as sheet:
        draw_panels(
            sheet, [Panel("force", "N", [TimeCurve("x", time, value, {"color": "k"})])], []
        )
    assert sheet.figure.notes == ("force x has 2 values that are not numbers",)


def test_labels_of_small_panels_do_not_meet(placed):
    time = np.linspace(0.0, 1.0, 3)
    panels = [
        Panel(name, unit, [TimeCurve("", time, size * time, {"color": SERIES[0]})])
        for name, unit, size in (
            ("pressure of bladder", "Pa", 2e3),
            ("volume of bladder", "m^3", 1e-4),
        )
    ]
    with new_sheet(85.0, 70.0) as sheet:
        axes = draw_panels(sheet, panels, [])
    sheet.figure.canvas.draw()
    upper, lower = (one.yaxis.label.get_window_extent() for one in axes)
    assert upper.y0 > lower.y1 and upper.y1 <= sheet.figure.bbox.y1 and lower.y0 >= 0.0
