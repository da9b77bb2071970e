"""The atlas holds what was measured and known of each tissue, and needs nothing else."""

import re
from html.parser import HTMLParser

import numpy as np
import pytest

from tissuec.analysis.lab.rows import Examination, LabCurve
from tissuec.analysis.lab.rows import TestRow as Row
from tissuec.core.source import Source
from tissuec.core.units import PRESSURE
from tissuec.pipeline import read_words
from tissuec.scene.request import Request
from tissuec.view.report.atlas import render
from tissuec.view.report.atlas_chart import HEIGHT, WIDTH, chart, even, powers, thinned

TEXT = """language 1
property softness from 0 to 1 { evenly = [soft, hard] }
quantity density from 1 g/cm^3 to 2 g/cm^3 { evenly = [low, high] }
rules simple { if softness is soft then density is low }
tissue gel {
  about "A <b>soft</b> gel & more."
  colour = "#aa3322"; gloss = 0.5
  described in simple; softness is soft
  Young's modulus = 5 kPa
  known Young's modulus from 4 kPa to 6 kPa by "Smith 2001"
  known stress in tension at [10 %, 30 %] from [0.4 kPa, 1 kPa] to [0.6 kPa, 2 kPa]
    by "Jones 2002"
}
tissue scar {
  Young's modulus = 50 kPa
  known relaxation at 2 s from 0.5 to 0.6 by unverified "Lee"
}
"""


def examined():
    """Return what a laboratory could have found of both tissues."""
    words, _ = read_words(Request(Source("t.tis", TEXT)))
    gel, scar = words.tissues["gel"], words.tissues["scar"]
    row = Row("tension", "Young's modulus", np.nan, 5e3, 5e3, gel.known, "good", True, PRESSURE)
    strain = np.array([0.1, 0.2, 0.3])
    curve = LabCurve("tension", strain, 5e3 * strain, 5e3 * strain, gel.curves)
    time = np.geomspace(0.01, 10.0, 400)
    relaxing = LabCurve("", time, 0.5 + 0.5 * np.exp(-time), np.full(400, np.nan), scar.curves)
    wrong = Row(
        "shear", "shear modulus", 1.0, 2.0, None, (), 'contradicts "X"', False, PRESSURE
    )
    return [
        Examination(gel, "one element", [row], [curve], ["a note"]),
        Examination(scar, "one element", [wrong], [relaxing], []),
    ]


class _Tags(HTMLParser):
    """Checks that elements are closed in order, and keeps what is asked of them."""

    def __init__(self):
        super().__init__()
        self.open, self.wrong, self.found = [], [], []

    def handle_starttag(self, tag, attributes):
        self.found.append((tag, dict(attributes)))
        if tag not in ("meta", "input", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag in ("input",):
            return
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)


@pytest.fixture(scope="module")
def page():
    return render(examined(), "Two tissues")


def test_the_page_is_whole_and_asks_for_nothing(page):
    tags = _Tags()
    tags.feed(page)
    assert not tags.wrong and not tags.open
    assert not re.search(r'(?:src|href)="(?!#)', page) and "http" not in page.split("<body")[1]
    ids = [attributes["id"] for _, attributes in tags.found if "id" in attributes]
    assert len(set(ids)) == len(ids)
    targets = [a["href"][1:] for tag, a in tags.found if tag == "a"]
    assert targets and set(targets) <= set(ids)


def test_the_page_names_words_numbers_sources_and_verdicts(page):
    for text in (
        "A &lt;b&gt;soft&lt;/b&gt; gel &amp; more.", "softness", "Smith 2001", "Jones 2002",
        "Lee (unverified)", "5 kPa", "contradicts", "1 of 1 not good", "a note",
        "2 tissues, 2 measurements", "contradictions in 1", "#aa3322",
    ):  # fmt: skip
        assert text in page, text


def test_tissues_are_found_by_all_that_is_said_of_them(page):
    texts = dict(re.findall(r'id="(gel|scar)"[^>]*data-text="([^"]*)"', page))
    assert "softness soft" in texts["gel"] and "jones 2002" in texts["gel"]
    assert "contradiction" in texts["scar"] and "smith" not in texts["scar"]
    assert "known stress in tension" in texts["gel"] and "known relaxation" in texts["scar"]


def test_lines_are_named_without_the_folders_of_whoever_made_the_page():
    words, _ = read_words(Request(Source("/home/me/t.tis", TEXT)))
    page = render([Examination(words.tissues["gel"], "", [], [], [])], "gel")
    assert "t.tis:5" in page and "/home" not in page


def test_a_single_tissue_needs_no_search():
    page = render(examined()[:1], "gel")
    assert 'id="search"' not in page and "All tissues" not in page


def test_tissues_of_the_same_name_have_places_of_their_own():
    gel = examined()[0]
    page = render([gel, gel, gel], "Three")
    found = re.findall(r'id="(gel[^"]*)" class="tissue-page"', page)
    assert found == ["gel", "gel--2", "gel--3"]


def test_a_drawing_shows_the_curve_its_law_its_scatter_and_where_it_tears():
    gel = examined()[0]
    drawn = chart(gel.curves[0], (0.4, 2e3))
    assert all(one in drawn for one in ('"measured"', '"law"', "polygon", "×", "Jones 2002"))
    places = [float(x) for x in re.findall(r'points="([\d.]+),', drawn)]
    assert all(0.0 <= x <= WIDTH for x in places)
    heights = [float(y) for y in re.findall(r",([\d.]+)[ \"]", drawn)]
    assert heights and all(0.0 <= y <= HEIGHT for y in heights)
    (line,) = re.findall(r'<polyline points="([^"]*)" class="measured"', drawn)
    x, y = np.array([[float(n) for n in one.split(",")] for one in line.split()]).T
    assert (np.diff(x) > 0.0).all() and (np.diff(y) < 0.0).all()  # up is down in SVG
    # Stress is proportional to strain here, so the line is straight.
    assert np.abs(np.diff(y) / np.diff(x) - (y[-1] - y[0]) / (x[-1] - x[0])).max() < 0.01


def test_a_relaxation_is_drawn_over_the_logarithm_of_time():
    scar = examined()[1]
    drawn = chart(thinned(scar.curves[0], 60))
    assert "time [s]" in drawn and "stress left [%]" in drawn and '"law"' not in drawn
    (line,) = re.findall(r'<polyline points="([^"]*)" class="measured"', drawn)
    assert 10 < len(line.split()) <= 60


@pytest.mark.parametrize(
    ("high", "last"), [(1.0, 1.0), (0.9, 1.0), (73.0, 80.0), (2.1e-4, 2.5e-4)]
)
def test_axes_end_with_round_numbers(high, last):
    axis = even(0.0, high, 0.0, 100.0)
    assert axis.ticks[-1] == pytest.approx(last) and axis.high >= high
    assert axis.place(0.0) == 0.0 and axis.place(axis.high) == pytest.approx(100.0)


def test_powers_of_ten_are_equally_far_apart():
    axis = powers(0.1, 100.0, 0.0, 30.0)
    assert [axis.place(one) for one in (0.1, 1.0, 10.0, 100.0)] == pytest.approx(
        [0, 10, 20, 30]
    )


# --- the command ------------------------------------------------------------------------------

BARE = "language 1\ntissue {} {{ Young's modulus = 5 kPa }}\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with two tissues and a file without any, in a laboratory that takes no time."""
    from tissuec.analysis.lab import laboratory

    def examine(request, tissue, **_):
        return Examination(tissue, "nothing", [], [], [])

    monkeypatch.setattr(laboratory, "examine", examine)
    monkeypatch.chdir(tmp_path)
    inside = tmp_path / "mine"
    inside.mkdir()
    for name in ("gel", "scar"):
        (inside / f"{name}.tis").write_text(BARE.format(name))
    (inside / "words.tis").write_text("language 1\nparam a = 1\n")
    return inside


def test_the_tissues_of_a_folder_come_on_one_page(folder):
    said = in_process("mine", "--page", "atlas.html")
    page = (folder.parent / "atlas.html").read_text(encoding="utf-8")
    assert said == 0
    assert "Atlas of mine" in page and 'id="gel"' in page and 'id="scar"' in page


def in_process(*arguments):
    from click.testing import CliRunner

    from tissuec.cli import group

    done = CliRunner().invoke(group, ["lab", *arguments], standalone_mode=False)
    if done.exception is not None:
        return str(done.exception)
    return done.return_value


def test_a_page_is_not_written_over_a_tissue_nor_without_its_ending(folder):
    assert "must end in .html" in in_process("mine", "--page", "mine/gel.tis")
    assert "no file of" in in_process("mine", "--tissue", "liver")
    (folder / "none").mkdir()
    assert "there is no file with tissues" in in_process("mine/none")
