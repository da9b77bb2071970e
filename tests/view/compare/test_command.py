"""``tissuec compare`` as it is typed: files of any kind, and exit codes."""

import json
import sys

import pytest

import tissuec
from tests.view.compare.scenes import OSCILLATOR
from tissuec.cli import main


@pytest.fixture
def say(monkeypatch, capsys):
    """Run the command line; return its exit code, and what it says on both streams."""

    def said(*words):
        monkeypatch.setattr(sys, "argv", ["tissuec", "compare", *map(str, words)])
        with pytest.raises(SystemExit) as end:
            main()
        return (end.value.code or 0, *capsys.readouterr())

    return said


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    for name, text in {
        "a": OSCILLATOR,
        "again": OSCILLATOR,
        "rough": OSCILLATOR.replace("1e-6", "1e-3"),
        "stiff": OSCILLATOR.replace("40 N/m", "44 N/m"),
        "short": OSCILLATOR.replace("0.3 s", "0.2 s"),
    }.items():
        (folder / f"{name}.tis").write_text(text)
        tissuec.run(folder / f"{name}.tis", out=folder / f"{name}.vtkhdf").close()
    (folder / "bad.tis").write_text(OSCILLATOR.replace("40 N/m", "40 N"))
    (folder / "cut.vtkhdf").write_bytes((folder / "a.vtkhdf").read_bytes()[:5000])
    (folder / "odd.tis").write_bytes((folder / "a.vtkhdf").read_bytes())
    return folder


SAME = [
    ("a.vtkhdf", "again.vtkhdf", "--within", "0"),
    ("a.tis", "again.tis"),
    ("a.tis", "a.vtkhdf"),
    ("a.vtkhdf", "a.vtkhdf"),
    ("odd.tis", "again.vtkhdf"),  # a result is known by what is in it, not by its name
]


@pytest.mark.parametrize("words", SAME, ids=" ".join)
def test_files_that_are_the_same_say_so(say, files, words):
    code, out, _ = say(files / words[0], files / words[1], *words[2:])
    assert code == 0 and out.splitlines()[-1].startswith("no differences")


BOUNDS = [("stiff", "0.1", 1), ("stiff", "2", 0), ("rough", "1e-3", 0), ("rough", "1e-12", 1)]


@pytest.mark.parametrize(("other", "bound", "expected"), BOUNDS)
def test_differences_are_no_failure_unless_a_bound_is_given(say, files, other, bound, expected):
    pair = files / "a.vtkhdf", files / f"{other}.vtkhdf"
    assert say(*pair)[0] == 0
    code, _, err = say(*pair, "--within", bound)
    assert code == expected
    assert ("of the largest displacement apart" in err) is (code == 1)


def test_a_run_that_ends_earlier_is_not_within_any_bound(say, files):
    code, _, err = say(files / "a.vtkhdf", files / "short.vtkhdf", "--within", "1")
    assert code == 1 and "not all nodes and times are in both" in err


def test_the_document_has_the_verdict(say, files):
    pair = files / "a.vtkhdf", files / "stiff.vtkhdf"
    code, out, err = say(*pair, "--within", "0.1", "--json", "-q")
    data = json.loads(out)
    assert (code, data["ok"], data["within"], err) == (1, False, 0.1, "")
    assert data["motion"]["relative"] > 0.1
    assert data["a"]["kind"] == "result"


WRONG = [
    (("a.tis", "a.vtkhdf", "--within", "1"), "--within compares motions"),
    (("a.vtkhdf", "nothere.vtkhdf"), 'there is no file "'),
    (("nothere.tis", "a.vtkhdf"), "TIS604"),
    (("a.vtkhdf", "bad.tis"), "TIS502"),
    (("cut.vtkhdf", "a.vtkhdf"), "truncated"),
]


@pytest.mark.parametrize(("words", "message"), WRONG)
def test_what_cannot_be_compared_is_exit_code_2(say, files, words, message):
    code, out, err = say(files / words[0], files / words[1], *words[2:])
    assert code == 2 and message in err and not out


def test_scenes_find_their_words_in_a_library(say, files, tmp_path):
    lines = OSCILLATOR.splitlines()
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "cords.tis").write_text(f"language 1\n{lines[1]}\n")
    (files / "uses.tis").write_text("\n".join([lines[0], 'use "own/cords"', *lines[2:], ""]))
    pair = files / "uses.tis", files / "a.tis"
    assert say(*pair)[0] == 2
    code, out, _ = say(*pair, "--library", tmp_path)
    assert code == 0 and 'only in a: "own/cords.tis"' in out
    assert "parameters" in out.splitlines()[-1]
