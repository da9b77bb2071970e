"""What a scene says about itself, from its text to the result and to figures of it."""

import re

import h5py
import pytest

from tests.every import every
from tests.findings import finding_of
from tests.view.report.runs import ROD, run
from tissuec.core.source import Source
from tissuec.pipeline import read_words
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request
from tissuec.view.plots import draw

SAID = {
    "about": "A rod <i>&amp;</i> what tears it.", "author": "Ada <b>Weiss</b>; Bo Li",
    "laboratory": "Institute & Co", "licence": "CC BY 4.0", "cite": "Weiss, Li: Rods. 2026.",
}  # fmt: skip


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    return run(tmp_path_factory.mktemp("said"), ROD)


def test_results_contain_what_their_scene_says_about_itself(result):
    with Trajectory.open(result) as trajectory:
        assert {word: trajectory.manifest[word] for word in SAID} == SAID
    with h5py.File(result) as file:
        assert file["h5md/author"].attrs["name"] == SAID["author"]


@pytest.mark.parametrize("suffix", ["png", "svg", "pdf"])
def test_figures_contain_it_too(result, suffix, tmp_path):
    pytest.importorskip("matplotlib")
    draw("logs", result).savefig(tmp_path / f"one.{suffix}", dpi=40)
    if suffix == "png":
        known = pytest.importorskip("PIL.Image").open(tmp_path / "one.png").text
        assert (known["Author"], known["Description"]) == (SAID["author"], SAID["about"])
        assert (known["Copyright"], known["Source"]) == (SAID["licence"], SAID["laboratory"])
    data = (tmp_path / f"one.{suffix}").read_bytes()
    assert b"CC BY 4.0" in data and b"Bo Li" in data


def declared(text):
    source = Source("scene.tis", f"language 1\n{text}\n")
    return read_words(Request(source))[0].declarations.metadata


def test_files_that_are_used_speak_for_themselves_only():
    assert declared('use "tissues/liver"\nauthor "A"').written == {"author": "A"}


@every(
    ("text", "message", "way_out"),
    [
        ('about "a"\nabout "b"', "about is given twice", ""),
        ('licence "a"\nlicence "a"', "licence is given twice", ""),
        ('license "x"', '"license" does not begin any part', 'did you mean "licence"?'),
        ('authors "A"', '"authors" does not begin any part', 'did you mean "author"?'),
        ("author Ada Weiss", "author needs a text in quotes", 'author "Ada Weiss"'),
        ('author is "Ada"', "author needs a text in quotes", 'author "Ada"'),
        ('cite = "x"', 'without "="', 'cite "x"'),
        ('cite ""', "the text is missing", ""),
    ],
)
def test_mistakes(text, message, way_out):
    found = finding_of(declared, text)
    assert message in found.message and way_out in str(found.hint or "")
    assert re.search(r"scene\.tis:[23]", str(found))
