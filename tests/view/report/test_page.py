"""What a page says is what the result says: every parameter, event and expectation of it."""

import json
import re
from contextlib import nullcontext
from hashlib import sha256
from itertools import pairwise

import numpy as np
import pytest
from click.testing import CliRunner

from tests.view.report.runs import BARE, ROD, UNSTABLE, WORDS, Page, page_of, run
from tests.whole_runs import AfterAsking
from tissuec.cli import group
from tissuec.core.errors import TissueError
from tissuec.core.signals import StopRequest
from tissuec.core.version import __version__
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.options import Options
from tissuec.view.report import origins
from tissuec.view.report.origins import stretches
from tissuec.view.report.page import chosen


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("report")


@pytest.fixture(scope="module")
def result(folder):
    """A run with words, params, tears, logs, energies, warnings and a failed expectation."""
    return run(folder, ROD, overrides=("far=9 mm",), companion="inline")


@pytest.fixture(scope="module")
def page(result):
    return Page(page_of(result))


def command(*words):
    return CliRunner().invoke(group, [str(word) for word in words], standalone_mode=False)


def places(element):
    """Return the places that an element shows, with the links that they are."""
    return {a.text: a.attributes["href"] for a in element.all("a") if ".tis:" in a.text}


def test_every_parameter_of_explain_is_there_with_a_link_to_its_line(folder, page):
    explained = json.loads(
        command("explain", folder / "scene.tis", "--json", "--set", "far=9 mm").stdout
    )
    section = page.section("numbers")
    shown = {place.rpartition("/")[2]: link for place, link in places(section).items()}
    tissue = explained["tissues"]["strand"]
    assert set(tissue["quantities"]) == {
        "spring constant", "viscosity", "mass", "breaking force",
    }  # fmt: skip
    wanted = [(name, fact["written"], fact["place"]) for name, fact in tissue["facts"].items()]
    for quantity in tissue["quantities"].values():
        for reason in quantity["reasons"]:
            wanted.append((quantity["quantity"], quantity["shown"], reason["place"]))
            assert reason["facts"] in section.text
    assert len({place for _, _, place in wanted}) >= 4
    for name, value, place in wanted:
        row = next(row for row in section.all("tr") if row.text.startswith(name))
        assert value in row.text
        line = int(place.rpartition(":")[2])
        assert page.line(shown[place.rpartition("/")[2]]) == WORDS.split("\n")[line - 1]
    rows = {row.children[0].text: row for row in section.all("tr") if row.children}
    assert set(explained["params"]) <= set(rows)
    assert "9 mm" in rows["far"].text and "set on the command line" in rows["far"].text
    (link,) = places(rows["far"]).values()
    assert page.line(link).startswith("param far = 6 mm")


def test_every_event_is_there(result, page):
    section = page.section("events")
    rows = [[cell.text for cell in row.children] for row in section.all("tr")[1:]]
    with Trajectory.open(result) as trajectory:
        events, clock = trajectory.events, trajectory.clock
        ids = trajectory.network.springs.ids
    assert {"fix", "move", "rupture", "trigger", "stop"} <= {event.kind for event in events}
    assert [row[:3] for row in rows] == [
        [clock.text(event.time, digits=6), event.kind, event.cause] for event in events
    ]
    named = [" ".join(str(ids[spring]) for spring in event.springs) for event in events]
    assert [row[3] for row in rows] == named
    assert all(places(row) for row in section.all("tr")[1:])


def test_expectations_are_told_with_what_was_measured(page):
    rows = page.section("expectations").all("tr")[1:]
    holds, torn, untorn = ([cell.text for cell in row.children] for row in rows)
    assert holds[0] == "✓ holds" and torn[0] == "✓ holds" and untorn[0] == "✗ fails"
    assert holds[2].startswith('distance(left, "<i>right</i>") = 3') and holds[3] == "300 ms"
    assert untorn[2] == 'ruptured("<b>rod</b> & co") = 2' and untorn[3] == "300 ms"
    (link,) = places(rows[2]).values()
    assert page.line(link) == 'expect not ruptured("<b>rod</b> & co") at 0.3 s'


def test_the_head_sums_the_run_up(result, page):
    (verdict,) = page.root.all("div", "verdict")
    assert "bad" in verdict.attributes["class"] and "Expectations fail" in verdict.text
    (summary,) = page.root.all("p", "summary")
    assert summary.text.startswith("4 nodes, 3 springs; 300 ms simulated; ")
    assert "rupture: 2 springs" in summary.text
    assert "expectations: 2 of 3 hold" in summary.text
    (made,) = page.root.all("p", "made")
    with Trajectory.open(result) as trajectory:
        for name, version in trajectory.manifest["versions"].items():
            assert f"{name} {version}" in made.text
    assert re.search(r"Run on \d\d \w+ \d{4}, \d\d:\d\d UTC", made.text)


def test_warnings_stand_at_their_lines(page):
    section = page.section("warnings")
    assert "W501" in section.text and "idle" in section.text
    assert any(page.line(link) == "param idle = 1 mm" for link in places(section).values())


def test_the_plan_is_that_of_explain(folder, page):
    said = command("explain", folder / "scene.tis", "--plan", "--set", "far=9 mm").stdout
    lines = said[said.index("method:") :].splitlines()
    told = page.section("plan").text.lower()
    for line in lines:
        assert line.strip().lower() in told


def test_the_manifest_is_there_to_its_last_entry(result, page):
    entries = page.section("manifest").all("dl")[0].children
    with Trajectory.open(result) as trajectory:
        manifest = trajectory.manifest
    told = {entry.children[0].text: entry.children[1].text for entry in entries}
    assert list(told) == list(manifest)
    assert told["digest"] == sha256(ROD.encode()).hexdigest()
    assert told["overrides"] == "far=9 mm"
    for name, value in manifest["statistics"].items():
        assert name in told["statistics"]
        if isinstance(value, int | float | str):
            assert str(value) in told["statistics"]


def test_the_command_runs_it_again_and_the_text_can_be_saved(folder, page):
    section = page.section("again")
    (line,) = section.all("pre", "command")
    assert line.text == f"tissuec run {folder / 'scene.tis'} --set 'far=9 mm'"
    from urllib.parse import unquote

    saved = {a.attributes["download"]: a.attributes["href"] for a in section.all("a")}
    assert unquote(saved["scene.tis"].partition(",")[2]) == ROD
    assert unquote(saved["words.tis"].partition(",")[2]) == WORDS


def test_texts_stand_there_as_they_are(page):
    for name, text in ((0, ROD), (1, WORDS)):
        lines = text.rstrip("\n").split("\n")
        shown = [page.ids[f"text-{name}-{number}"].text for number in range(1, len(lines) + 1)]
        assert [line.rstrip("\n") for line in shown] == lines
    used = page.ids["text-1"]
    assert used.tag == "details" and "open" not in used.attributes


def test_nothing_of_a_text_becomes_markup(page):
    """Names, remarks and causes hold tags; they all come back as text."""
    assert {e.tag for e in page.section("text").all()} <= {
        "h2", "pre", "code", "span", "a", "details", "summary",
    }  # fmt: skip
    assert not page.root.all("i", None) or all(
        i.parent.attributes.get("class") == "bar" for i in page.root.all("i")
    )
    assert len(page.root.all("script")) == 1
    assert "A rod <i>&amp;</i> what tears it." in page.root.all("p", "about")[0].text


def test_a_page_needs_nothing_beside_it(page):
    for element in page.root.all():
        for name in ("src", "href", "data", "action", "poster"):
            target = element.attributes.get(name) or ""
            assert not target or target[0] == "#" or target.startswith("data:"), target
    (style,) = page.root.all("style")
    assert "url(" not in style.text and "@import" not in style.text


def test_every_link_within_the_page_leads_somewhere(page):
    targets = [e.attributes["href"][1:] for e in page.root.all("a") if "href" in e.attributes]
    assert all(t in page.ids for t in targets if not t.startswith("ata:"))
    every = [e.attributes["id"] for e in page.root.all() if "id" in e.attributes]
    assert len(set(every)) == len(every)


def test_tables_and_headings_are_fit_to_be_read_aloud(page):
    for table in page.root.all("table"):
        assert table.all("caption")[0].text
        assert all(head.attributes.get("scope") for head in table.all("th"))
    levels = [int(e.tag[1]) for e in page.root.all() if re.fullmatch(r"h\d", e.tag)]
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))


# --- other runs ---


def test_a_run_of_bare_nodes_has_a_page(tmp_path):
    page = Page(page_of(run(tmp_path, BARE)))
    assert "2 nodes, 0 springs" in page.root.all("p", "summary")[0].text
    assert "no trajectory" in page.section("motion").text
    assert page.section("curves") is None and page.section("expectations") is None
    assert "Done" in page.root.all("div", "verdict")[0].text


@pytest.mark.usefixtures("without_pictures")
def test_a_run_that_diverged_says_so_first(tmp_path):
    page = Page(page_of(run(tmp_path, UNSTABLE)))
    (verdict,) = page.root.all("div", "verdict")
    with Trajectory.open(tmp_path / "scene.partial.vtkhdf") as trajectory:
        outcome = trajectory.outcome
    assert "Stopped" in verdict.text and outcome in verdict.text
    assert "… not reached" in page.section("expectations").text
    assert " of 2 s simulated; velocity verlet, " in page.root.all("p", "summary")[0].text


@pytest.mark.usefixtures("without_pictures")
def test_a_killed_run_is_unfinished(tmp_path, example):
    """Its file has no statistics, and its text has no body to be compiled."""
    path = tmp_path / "killed.vtkhdf"
    writer = example.open(path)
    example.write(writer, 0, 20)
    writer.flush()
    page = Page(page_of(tmp_path / "killed.partial.vtkhdf"))
    writer.close("interrupted at 0.8 s", finished=False)
    assert "Unfinished" in page.root.all("div", "verdict")[0].text
    assert "in progress or was killed" in page.section("run").text
    assert "cannot be compiled" in page.root.all("div", "doubts")[0].text
    assert "cut" in page.section("events").text


@pytest.mark.usefixtures("without_pictures")
def test_an_older_result_tells_what_it_has(tmp_path, result, monkeypatch):
    """Files of earlier versions have neither expectations nor a beginning in the manifest."""
    with Trajectory.open(result) as trajectory:
        for name in ("expectations", "begun", "libraries"):
            del trajectory.manifest[name]
        trajectory.manifest["versions"]["tissuec"] = "0.0.1"
        from tissuec.view.report.content import ReportContent
        from tissuec.view.report.page import render

        page = Page(render(ReportContent(trajectory)))
    assert "does not record which" in page.section("expectations").text
    assert "… not recorded" in page.section("expectations").text
    assert "run with tissuec 0.0.1" in page.root.all("div", "doubts")[0].text
    assert "at an unknown time" in page.root.all("p", "made")[0].text


@pytest.mark.usefixtures("without_pictures")
def test_a_changed_text_is_told(result):
    with Trajectory.open(result) as trajectory:
        trajectory.__dict__["text"] = trajectory.text.replace("20 0 0", "21 0 0")
        from tissuec.view.report.content import ReportContent
        from tissuec.view.report.page import render

        page = Page(render(ReportContent(trajectory)))
    doubts = page.root.all("div", "doubts")[0].text
    assert "another digest" in doubts
    assert "another net" in doubts and "position differs" in doubts
    assert "could not be compiled again" in page.section("plan").text


TABLED = """language 1
tissue strand { spring constant = 40 N/m; viscosity = 0.02 N*s/m; mass = 1 g }
body rod { mesh is imported { file "rod.obj" in mm }; tissue is strand }
set left = nodes of rod where x < 1 mm
set right = nodes of rod where x > 9 mm
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix left
  from 0 s to 0.1 s: move right along table "path.csv" in mm
}
simulate { duration = 0.1 s }
output { trajectory every 10 ms }
"""
OBJ = "v 0 0 0\nv 10 0 0\nv 5 5 0\nv 5 2 5\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n"
CSV = "time,x,y,z\n0,0,0,0\n0.1,1,0,0\n"


@pytest.mark.usefixtures("without_pictures")
def test_files_that_are_absent_are_named_and_the_rest_is_there(tmp_path):
    (tmp_path / "rod.obj").write_text(OBJ)
    (tmp_path / "path.csv").write_text(CSV)
    path = run(tmp_path, TABLED)
    there = Page(page_of(path))
    assert not there.root.all("div", "doubts")
    for name in ("scene.tis", "words.tis", "path.csv"):
        (tmp_path / name).unlink()
    assert not Page(page_of(path)).root.all("div", "doubts")  # these are kept
    (tmp_path / "rod.obj").rename(tmp_path / "other.obj")
    page = Page(page_of(path))
    doubts = page.root.all("div", "doubts")[0].text
    assert "cannot be compiled" in doubts and "rod.obj" in doubts
    assert "40 N/m" in page.section("numbers").text
    assert "contact: nothing can be in contact" in page.section("plan").text
    assert page.section("text").text.count("0.1,1,0,0") == 1
    (tmp_path / "rod.obj").write_text(OBJ.replace("5 2 5", "5 2 6"))
    page = Page(page_of(path))
    assert '"rod.obj" has changed' in page.root.all("div", "doubts")[0].text


# --- curves and motion ---


def test_authors_licence_and_what_to_cite_are_stated(page):
    assert "Ada <b>Weiss</b>; Bo Li · Institute & Co · licence: CC BY 4.0" in [
        line.text for line in page.root.all("p", "credits")
    ]
    names, texts = ([e.text for e in page.section("cite").all(tag)] for tag in ("dt", "dd"))
    facts = dict(zip(names, texts, strict=True))
    assert facts["scene"] == "Weiss, Li: Rods. 2026."
    assert f"tissuec {__version__}" in facts["program"] and "Nürnberger" in facts["method"]


def test_every_figure_and_table_has_one_caption(page):
    for figure in page.root.all("figure"):
        assert len(figure.all("figcaption")) == 1, figure
        assert re.fullmatch(r"[A-Z].+\.", figure.all("figcaption")[0].text)
    assert all(table.all("caption")[0].text.endswith(".") for table in page.root.all("table"))
    assert all(picture.parent.tag == "figure" for picture in page.root.all("iframe"))


def test_curves_are_drawn_in_the_page_and_follow_it_into_the_dark(page):
    pytest.importorskip("matplotlib")
    section = page.section("curves")
    drawn = section.all("svg")
    assert len(drawn) == len(section.all("figure")) == 3
    labels = [picture.parent.attributes["aria-label"] for picture in drawn]
    assert [label.split(" of ")[0] for label in labels] == ["logs", "energies", "errors"]
    styles = {e.attributes.get("style", "") for picture in drawn for e in picture.all()}
    assert any("var(--ink)" in style for style in styles)
    assert not any(colour in style for style in styles for colour in ("#222222", "#ffffff"))
    assert not any(picture.all("metadata") or picture.all("style") for picture in drawn)


def test_extremes_of_logs_are_told_in_numbers(result, page):
    rows = {row.children[0].text: row for row in page.section("curves").all("tr")[1:]}
    with Trajectory.open(result) as trajectory:
        (log,) = trajectory.logs.values()
        for number, column in enumerate(log.columns):
            cells = [cell.text for cell in rows[f"{log.name}: {column}"].children[1:]]
            value = log.with_jumps()[1][:, number]
            numbers = np.array([value.min(), value.max(), value[-1]]) / 1e-3
            assert cells == [*(f"{one:.4g}" for one in numbers), "mN"]


def test_without_matplotlib_the_page_says_what_brings_it(result, monkeypatch):
    def missing():
        raise TissueError('a plot needs matplotlib; install it: pip install "tissuec[plot]"')

    monkeypatch.setattr("tissuec.view.report.page.need_matplotlib", missing)
    page = Page(page_of(result))
    assert 'install it: pip install "tissuec[plot]".' in page.section("curves").text
    assert not page.root.all("svg") and not page.root.all("img")
    assert page.section("curves").all("table") and page.section("numbers").all("table")


def test_the_player_stands_in_a_frame_of_its_own(page):
    (frame,) = page.section("motion").all("iframe")
    assert frame.attributes["srcdoc"].lower().startswith("<!doctype html>")
    assert frame.attributes["title"]


def test_long_runs_of_large_nets_are_thinned_and_the_page_says_so():
    assert chosen(100, 160) == (Options(), "")
    assert chosen(5000, 160) == (Options(frames=2500), "2500 of 5000 frames")
    many = Options(frames=20, nodes=20_000)
    assert chosen(50, 100_000) == (many, "20 of 50 frames and 20000 of 100000 nodes")


def test_long_texts_show_their_beginning_and_what_is_led_to():
    shown = list(stretches(10_000, {9_000}))
    assert shown == [
        (1, 1501, True), (1501, 8997, False), (8997, 9004, True), (9004, 10_001, False),
    ]  # fmt: skip
    assert list(stretches(3000, {5})) == [(1, 3001, True)]


@pytest.mark.usefixtures("without_pictures")
def test_texts_that_are_too_long_to_be_saved_from_the_page_are_found_elsewhere(
    result, monkeypatch
):
    monkeypatch.setattr(origins, "LONGEST", 1000)
    section = Page(page_of(result)).section("again")
    saved = [link.attributes["download"] for link in section.all("a")]
    assert saved == ["words.tis"]
    assert (
        "scene.tis is too long for a page; tissuec.load(…).sources contains it" in section.text
    )
    with Trajectory.open(result) as trajectory:
        assert ROD in [source.text for source in trajectory.sources.values()]


@pytest.mark.usefixtures("without_pictures")
def test_a_run_that_was_resumed_has_all_events_and_expectations(tmp_path, monkeypatch):
    from tissuec.engine.execution import run as running
    from tissuec.pipeline import compile_request, simulate
    from tissuec.scene.request import Request

    whole = Page(page_of(run(tmp_path, ROD, "whole")))
    stop = StopRequest(AfterAsking(3))
    monkeypatch.setattr(running, "asked_to_stop", lambda interrupt: nullcontext(stop))
    path = run(tmp_path, ROD, "halves")
    page = Page(page_of(path))
    assert "Unfinished" in page.root.all("div", "verdict")[0].text
    assert "--resume" in page.section("again").text
    assert {c.text for c in page.section("expectations").all("span", "mark")} == {
        "… not reached"
    }
    monkeypatch.undo()
    request = Request.file(tmp_path / "halves.tis")
    compiled, _ = compile_request(request)
    path = simulate(compiled, path, request=request, resume=True).path
    page = Page(page_of(path))
    for key in ("events", "expectations"):
        assert page.section(key).text == whole.section(key).text.replace("whole", "halves")
