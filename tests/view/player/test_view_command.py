"""``tissuec view`` at the command line."""

import json
import shutil
import sys

import numpy as np
import pytest

from tests.every import every
from tests.test_docs import tissuec
from tests.test_progress import Terminal
from tests.view.player.conftest import Show, grid
from tissuec.cli.view import field_range
from tissuec.results.trajectory import Trajectory
from tissuec.view.player.fields import known_fields
from tissuec.view.player.options import Options
from tissuec.view.player.picture import Painter
from tissuec.view.player.reading import read_film


@pytest.fixture
def made(tmp_path, monkeypatch):
    """A result in the present folder."""
    monkeypatch.chdir(tmp_path)
    return Show(grid(8, 8), frames=11, logs={"force": [1.0, 2.0]}).write(
        tmp_path / "made.vtkhdf"
    )


def view(*words):
    return tissuec(["tissuec", "view", *map(str, words)])


def test_a_page_is_written_into_the_present_folder(made, tmp_path, capsys):
    (tmp_path / "sub").mkdir()
    shutil.move(made, tmp_path / "sub" / "made.vtkhdf")
    assert view("sub/made.vtkhdf") == 0
    said = capsys.readouterr()
    assert said.out == "" and said.err.startswith("wrote made.html: 11 frames, ")
    assert (tmp_path / "made.html").read_text(encoding="utf-8").startswith("<!doctype html>")
    assert view("sub/made.vtkhdf", "-q") == 0  # replaces it
    assert capsys.readouterr().err == ""
    assert not list(tmp_path.glob("*.new"))


def test_json_says_what_was_written(made, capsys):
    assert view(made, "--json", "--every", "40 ms", "--nodes", 20, "-o", "other.html") == 0
    found = json.loads(capsys.readouterr().out)
    assert found["frames"] == 6 and 10 < found["nodes"] <= 20
    assert found["page"]["file"] == "other.html"
    assert found["page"]["bytes"] == (made.parent / "other.html").stat().st_size


def test_pictures_of_simplified_nets_say_so(made, capsys):
    Text = pytest.importorskip("matplotlib.text").Text
    said = "drawn: 16 of 64 nodes; "
    small = ("--size", "320x240")
    assert view(made, "--png", "few.png", "--nodes", 20, *small) == 0
    assert said in capsys.readouterr().err
    assert view(made, "--png", "all.png", *small) == 0
    assert "drawn" not in capsys.readouterr().err
    with Trajectory.open(made) as trajectory:
        for nodes in (20, None):
            film = read_film(trajectory, options := Options(nodes=nodes))
            picture = Painter(film, options, (320, 240), "made").draw(0.0)
            notes = [one.get_text() for one in picture.findobj(Text)]
            assert any(note.startswith(said) for note in notes) == (nodes is not None)


def test_several_results_are_several_pages(made, tmp_path, capsys):
    second = shutil.copy(made, tmp_path / "second.vtkhdf")
    assert view(made, second, "--json") == 0
    pages = [one["page"]["file"] for one in json.loads(capsys.readouterr().out)]
    assert pages == ["made.html", "second.html"]
    (tmp_path / "sub").mkdir()
    third = shutil.copy(made, tmp_path / "sub" / "made.vtkhdf")
    assert view(made, third) == 2
    assert "would both be" in capsys.readouterr().err


def test_a_terminal_tells_which_picture_is_drawn(made, monkeypatch):
    pytest.importorskip("PIL.Image")
    pytest.importorskip("matplotlib")
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    assert view(made, "--gif", "film.gif", "--frames", 3, "--size", "60x40") == 0
    said = terminal.getvalue()
    assert said.startswith("\rpicture 1 of ")
    assert "\r\033[Kwrote film.gif: " in said


def test_pictures_are_drawn_without_a_page(made, tmp_path, capsys):
    Image = pytest.importorskip("PIL.Image")
    pytest.importorskip("matplotlib")
    words = ("--png", "one.png", "--time", "0.1", "--size", "200x120", "--from", "-90,0")
    assert view(made, *words, "--forces") == 0
    assert capsys.readouterr().err == "wrote one.png: t = 100 ms\n"
    assert Image.open(tmp_path / "one.png").size == (200, 120)
    assert not (tmp_path / "made.html").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["-o", "x.png"], 'must end in .html, unlike'),
        (["--png", "x.jpg"], "ends in .png: tissuec view made.vtkhdf --png made.png"),
        (["-o", "x.gif"], "for a picture write --gif x.gif"),
        (["--size", "10x10", "--png", "x.png"], "must be between 16 and 8192"),
        (["--size", "100", "--png", "x.png"], "does not have the form WIDTHxHEIGHT"),
        (["--size", "100x100"], "--size is for pictures"),
        (["--forces"], "--forces is for pictures"),
        (["--from", "north"], "does not have the form AZIMUTH,ELEVATION"),
        (["--time", "3 mm"], '"3 mm" is not a time'),
        (["--every", "0"], "--every must be above 0"),
        (["--every", "nan"], "is not a time"),
        (["--frames", "1"], "--frames"),
        (["--colour", "red"], "--colour"),
        (["made.vtkhdf", "-o", "x.html"], "-o is for one result"),
        (["--png", "x.png", "--open"], "--open needs a page"),
    ],
)  # fmt: skip
def test_what_does_not_go_together_is_refused(made, capsys, words, said):
    assert view("made.vtkhdf" if words[0] != "made.vtkhdf" else "other", *words) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        ["--gif", "made.vtkhdf"],
        ["made.vtkhdf", "--gif"],
        ["--gif", "made.vtkhdf", "-o", "x.gif"],
        ["made.vtkhdf", "--gif", "-o", "x.gif"],
        ["--gif", "--quiet", "made.vtkhdf"],
    ],
)
def test_a_picture_without_its_name_is_answered_with_the_whole_command(made, capsys, words):
    assert view(*words) == 2
    picture = "x.gif" if "x.gif" in words else "made.gif"
    said = f"ends in .gif: tissuec view made.vtkhdf --gif {picture}"
    assert said in capsys.readouterr().err


def test_files_of_others_stay(made, tmp_path, capsys):
    (tmp_path / "made.html").write_text("<h1>My thesis</h1>")
    assert view(made) == 2
    assert "exists and is not a page of tissuec" in capsys.readouterr().err
    assert (tmp_path / "made.html").read_text() == "<h1>My thesis</h1>"
    linked = tmp_path / "linked.html"
    linked.symlink_to(made)
    assert view(made, "-o", linked) == 2
    assert "is the input file" in capsys.readouterr().err
    assert view(tmp_path / "none.vtkhdf") == 2
    assert "there is no file" in capsys.readouterr().err


def test_missing_extras_are_named_before_any_work(made, tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setenv("PATH", "")
    pytest.importorskip("matplotlib")
    assert view(made, "--mp4", "x.mp4") == 2
    assert 'pip install "tissuec[animate]"' in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    assert view(made, "--gif", "x.gif", "-o", "x.html") == 2
    assert 'pip install "tissuec[plot]"' in capsys.readouterr().err
    assert not list(tmp_path.glob("x.*"))


def test_it_can_be_shown_at_once(made, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    assert view(made, "--open", "-q") == 0
    assert opened == [(made.parent / "made.html").as_uri()]


def test_a_page_needs_no_extra(made, monkeypatch):
    for name in ("matplotlib", "PIL", "imageio_ffmpeg"):
        monkeypatch.setitem(sys.modules, name, None)
    assert view(made, "-q") == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--field heat", "'heat' is not one of 'tissue', 'displacement', 'speed'"),
        ("--field stress", "has no stress; fields of this result: displacement, speed, strain"),
        ("--range 0,1", '--range needs the field whose colours it limits: --field strain'),
        ("--field strain --range 1", '"1" does not have the form LOW,HIGH; write'),
        ("--field strain --range 2%,1%", 'the first number of "2%,1%" must be smaller'),
        ("--field strain --range 0,20", 'strain needs a unit; write --range "0,20 %"'),
        ("--section z=1mm --section z=2mm", "--section is given twice: give it once"),
        ("--field speed --range 0,2", 'speed needs a unit; write --range "0,2 mm/s"'),
        ("--field strain --range 0,2mm", '"mm" is not a unit of strain; write --range "0,20'),
        ("--field force --range 0,2furlong", '"furlong" is not a unit; write --range "0,2 mN"'),
        ("--field force --range 0,1e999N", 'a number of this range is too large'),
    ],
)  # fmt: skip
def test_fields_and_ranges_that_are_none_are_answered(made, capsys, words, said):
    assert view(made, *words.split()) == 2
    assert said in capsys.readouterr().err.replace("\n", " ")
    assert not list(made.parent.glob("*.html"))


@every(
    "text",
    ("0,20 %", "0 %,20%", "0 .. 20 %", "0..0.2e2 %", "0 % to 20 %", "0 … 20 %", "0 to 20%"),
)
def test_ranges_have_the_form_of_the_legend_or_of_the_language(text):
    strain = known_fields()["strain"]
    assert field_range(text, strain) == pytest.approx((0.0, 0.2))


def test_pictures_have_the_colours_of_their_field(made, capsys):
    """The sheet at rest has the lowest colour, in the legend its name and a mark."""
    pytest.importorskip("matplotlib")
    Image = pytest.importorskip("PIL.Image")
    from tissuec.core import palette

    found = []
    for limit in ("1 mm", "100 mm"):
        words = ("--field", "displacement", "--range", f"0,{limit}", "--size", "320x240")
        assert view(made, *words, "--png", "still.png", "--from", "-90,90", "-q") == 0
        found.append(np.asarray(Image.open("still.png").convert("RGB")).astype(int))
    ends = [[int(text[k : k + 2], 16) for k in (1, 3, 5)]
            for text in (palette.AMOUNT[-1], palette.AMOUNT[0])]  # fmt: skip
    for shot, end in zip(found, ends, strict=True):
        # Waves of 20 mm and more: nearly all of it is beyond 1 mm, and little of 100 mm.
        assert (np.abs(shot[40:180] - end).max(axis=2) < 70).mean() > 0.1
