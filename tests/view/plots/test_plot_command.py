"""``tissuec plot`` as users meet it: names of files, options, notes, JSON and errors."""

import json
import subprocess
import sys

import pytest
from click.testing import CliRunner

from tissuec.cli import group
from tissuec.core.errors import TissueError
from tissuec.view.plots import PLOTS, draw

pytestmark = pytest.mark.usefixtures("unplaced")


@pytest.fixture
def call(tmp_path, monkeypatch):
    """Return a function that plots in a folder of its own; gives exit code and outputs."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        words = ["plot", *map(str, arguments)]
        result = CliRunner().invoke(group, words, standalone_mode=False)
        if result.exception is not None:
            raise result.exception
        return result.return_value, result.stdout, result.stderr

    return call


@pytest.mark.parametrize(
    ("file", "name"),
    [
        ("strip.vtkhdf", "strip.png"),
        ("fuzzy/soft_tissue", "soft_tissue.png"),
        ("bench.json", "bench.png"),
        ("stress.json", "stress.png"),
        ("strip.tis", "strip.png"),
    ],
)
def test_without_options_there_is_a_picture_here(call, folder, tmp_path, file, name):
    given = file if "/" in file else folder / file
    assert call(given) == (0, "", f"wrote {name}\n")
    assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")


def test_the_document_says_what_was_written(call, result, tmp_path):
    code, out, err = call(
        result, "--kind", "frames", "--time", "40ms", "--times", "0.1", "-o", "x.svg", "--json"
    )
    assert (code, err) == (0, "")
    found = json.loads(out)
    assert found["ok"] is True
    assert (found["file"], found["kind"], found["notes"]) == ("x.svg", "frames", [])
    assert found["drawn_of"] == [str(result)]
    assert found["size_mm"][0] == 180.0
    text = (tmp_path / "x.svg").read_text(encoding="utf-8")
    assert ">40 ms</text>" in text and ">100 ms: cut at 60 ms</text>" in text


@pytest.mark.parametrize(
    ("options", "kind"),
    [
        (["--log", "length of strip"], "logs"),
        (["--of", "right end"], "paths"),
        (["--time", "0.1"], "frames"),
        (["--lines"], "energies"),
        (["--x", "time", "--y", "force of right end"], "x-y"),
        (["--from=-90,0"], "overview"),
    ],
)
def test_options_say_which_kind_is_meant(call, result, options, kind):
    assert json.loads(call(result, *options, "--json")[1])["kind"] == kind


def test_several_results_are_overlaid_without_being_asked(call, result, later):
    assert json.loads(call(result, later, "--json")[1])["kind"] == "logs"


def test_a_picture_has_the_size_that_is_asked(call, result, tmp_path):
    call(result, "--kind", "logs", "--size", "100x80", "--dpi", "254", "-o", "a.png")
    head = (tmp_path / "a.png").read_bytes()[16:24]
    assert (int.from_bytes(head[:4]), int.from_bytes(head[4:])) == (1000, 800)


def test_what_is_set_reaches_a_text(call, tmp_path, folder):
    text = "language 1\nparam top = 5\nproperty p from 0 to top { evenly = [a, b] }\n"
    (tmp_path / "p.tis").write_text(text, encoding="utf-8")
    assert call("p.tis", "--set", "top=9")[0] == 0
    figure = draw("words", tmp_path / "p.tis", overrides=("top=9",))
    assert figure.axes[0].get_xlim() == (0.0, 9.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["strip.vtkhdf", "--kind", "log"], 'no kind of plot called "log"; did you mean "log'),
        (["strip.vtkhdf", "--kind", "frames", "--log", "x"], 'frames has no option "log"'),
        (["strip.vtkhdf", "--kind", "logs", "--log", "forc"], 'there is no log "forc"'),
        (["strip.vtkhdf", "--kind", "words"], "plots of it: energies, envelope, errors"),
        (["strip.vtkhdf", "strip.vtkhdf", "--kind", "frames"], "needs one file, not 2"),
        (["strip.vtkhdf", "-o", "a.jpg"], r"ends with \.jpg; the name of a picture must end "
        r"with \.png, \.svg"),
        (["strip.vtkhdf", "-o", "picture"], "has no ending"),
        (["strip.vtkhdf", "-o", "nowhere/a.png"], "cannot write"),
        (["strip.vtkhdf", "--start", "3 kg"], '"3 kg" is not a time'),
        (["strip.vtkhdf", "--start", "soon"], '"soon" is not a time'),
        (["strip.vtkhdf", "--size", "1x1"], "between 30 mm and 2000 mm"),
        (["strip.vtkhdf", "--size", "nan"], "WIDTHxHEIGHT"),
        (["strip.vtkhdf", "--size", "nanxnan"], "between 30 mm and 2000 mm"),
        (["strip.vtkhdf", "--from", "0,91"], "between -90 and 90"),
        (["strip.vtkhdf", "--from", "up"], "AZIMUTH,ELEVATION"),
        (["stripp.vtkhdf"], 'there is no file .*; did you mean ".*strip.vtkhdf"'),
        (["missing.json"], "cannot read"),
        (["bad.json"], "is not JSON"),
        (["other.json"], "nothing to plot; plots accept the JSON of"),
        (["failed.json"], "no reference came out"),
        (["nothing.tis"], "there is no vocabulary"),
        (["strip.vtkhdf", "bench.json", "--kind", "logs"], "the plot logs needs a result"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_with_a_remedy(call, folder, arguments, message):
    (folder / "bad.json").write_text("{", encoding="utf-8")
    (folder / "other.json").write_text('{"ok": true}', encoding="utf-8")
    failed = {"ok": False, "error": "no reference came out"}
    (folder / "failed.json").write_text(json.dumps(failed), encoding="utf-8")
    known = (".vtkhdf", ".json", ".tis")
    given = [str(folder / word) if word.endswith(known) else word for word in arguments]
    with pytest.raises(Exception, match=message):
        call(*given)


def test_what_is_read_is_not_written_over(call, folder, tmp_path):
    (tmp_path / "bench.png").write_text((folder / "bench.json").read_text(), encoding="utf-8")
    with pytest.raises(TissueError, match="is the input file"):
        call("bench.png", "-o", "bench.png")


def test_without_matplotlib_the_extra_is_named(call, result, monkeypatch):
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(TissueError, match=r'install it: pip install "tissuec\[plot\]"'):
        call(result)
    with pytest.raises(TissueError, match=r"tissuec\[plot\]"):
        draw("logs", result)


def test_wrong_text_ends_with_two_and_shows_its_place(call, tmp_path):
    (tmp_path / "wrong.tis").write_text("language 1\nproperty p from 0 to {", encoding="utf-8")
    code, _, err = call("wrong.tis")
    assert code == 2
    assert "wrong.tis:2" in err


def test_help_and_kinds_need_neither_matplotlib_nor_files(repository):
    code = (
        "import sys\nimport tissuec.cli.plot\nfrom tissuec.view.plots import PLOTS\n"
        "list(PLOTS)\n"
        "print([n for n in ('matplotlib', 'h5py', 'scipy', 'numba') if n in sys.modules])"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=repository, capture_output=True, text=True
    )
    assert run.stdout.strip() == "[]", run.stderr


def test_help_names_every_kind(call):
    _, out, _ = call("--help")
    assert all(name in "".join(out.split()) for name in PLOTS)


def test_from_python_open_results_and_texts_can_be_given(strip):
    figure = draw("logs", strip, log="length of strip", title="A strip")
    assert figure._suptitle.get_text() == "A strip"
    assert strip.times[0] == 0.0  # it is still open
    with pytest.raises(ValueError, match="give at least one file"):
        draw("logs")
    with pytest.raises(ValueError, match="int cannot be plotted"):
        draw("logs", 3)
    with pytest.raises(ValueError, match='logs has no option "logg"; did you mean "log"'):
        draw("logs", strip, logg="x")
