"""``tissuec report`` as users meet it: files, options, exit codes."""

import json

import pytest
from click import UsageError
from click.testing import CliRunner

from tests.validate.scenes import rod
from tests.view.report.runs import BARE, UNSTABLE, Page, run
from tissuec.cli import group
from tissuec.core.errors import TissueError

pytestmark = pytest.mark.usefixtures("without_pictures")


def command(*words):
    """Return exit code, stdout and stderr; errors are raised."""
    found = CliRunner().invoke(group, [str(word) for word in words], standalone_mode=False)
    if found.exception is not None:
        raise found.exception
    return found.return_value, found.stdout, found.stderr


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with two results: a rod between two ends, and bare nodes."""
    folder = tmp_path_factory.mktemp("command")
    run(folder, rod(), "rod")
    run(folder, BARE, "bare")
    return folder


@pytest.fixture(autouse=True)
def here(folder, monkeypatch):
    monkeypatch.chdir(folder)


def test_a_page_is_named_after_the_result_and_lies_in_the_present_folder(folder):
    code, out, err = command("report", "rod.vtkhdf")
    assert (code, out) == (0, "")
    assert err == "rod.vtkhdf: done\n  report: rod.report.html\n"
    assert Page((folder / "rod.report.html").read_text(encoding="utf-8")).section("motion")


def test_the_same_result_gives_the_same_page(folder):
    command("report", "rod.vtkhdf", "-o", "one.html")
    command("report", "rod.vtkhdf", "-o", "other.html")
    assert (folder / "one.html").read_bytes() == (folder / "other.html").read_bytes()


def test_several_results_go_into_a_folder(folder):
    code, out, _ = command("report", "rod.vtkhdf", "bare.vtkhdf", "-o", "pages", "--json")
    documents = json.loads(out)
    assert code == 0
    assert [document["verdict"] for document in documents] == ["done", "done"]
    for document in documents:
        path = folder / document["report"]
        assert path.parent.name == "pages" and path.stat().st_size == document["bytes"]


def test_two_pages_are_never_one_file(folder):
    (folder / "again").mkdir(exist_ok=True)
    (folder / "again" / "rod.vtkhdf").write_bytes((folder / "rod.vtkhdf").read_bytes())
    with pytest.raises(TissueError, match="would both be"):
        command("report", "rod.vtkhdf", "again/rod.vtkhdf")


def test_a_page_never_replaces_what_it_is_about(folder):
    (folder / "link.html").symlink_to(folder / "rod.vtkhdf")
    before = (folder / "rod.vtkhdf").read_bytes()
    with pytest.raises(TissueError, match="is the input file"):
        command("report", "rod.vtkhdf", "-o", "link.html")
    assert (folder / "rod.vtkhdf").read_bytes() == before


@pytest.mark.parametrize("name", ["rod.tis", "rod.vtkhdf", "measured.csv"])
def test_a_page_never_replaces_a_file_that_is_none(folder, name):
    (folder / name).touch()
    before = (folder / name).read_bytes()
    with pytest.raises(UsageError, match=r"must end in \.html"):
        command("report", "bare.vtkhdf", "-o", name)
    assert (folder / name).read_bytes() == before


def test_validation_in_place_is_that_of_validate(folder):
    code, _, err = command("report", "rod.vtkhdf", "--validate", "-o", "valid.html")
    assert code == 0
    assert err.startswith("run …\nreference, DOP853 with rtol")
    _, said, _ = command("validate", "rod.tis", "-q")
    page = Page((folder / "valid.html").read_text(encoding="utf-8"))
    section = page.section("validation")
    heads, *rows = ([cell.text for cell in row.children] for row in section.all("tr"))
    assert "✓ PASS: errors are within their limits (tolerance 0.0001)" in section.text
    table = said[: said.index("(…)")].splitlines()
    assert table[0].split() == " ".join(heads).split()
    for row, line in zip(rows, table[1:], strict=True):
        assert " ".join(row).split() == line.split()


def test_validation_from_a_file_is_the_same(folder):
    _, out, _ = command("validate", "rod.tis", "--json")
    (folder / "rod.json").write_text(out)
    code, _, err = command("report", "rod.vtkhdf", "--validation", "rod.json", "-o", "v.html")
    assert (code, err) == (0, "rod.vtkhdf: done\n  report: v.html\n")
    section = Page((folder / "v.html").read_text(encoding="utf-8")).section("validation")
    for quantity in json.loads(out)["quantities"]:
        assert f"{quantity['error']:.2e}" in section.text
    with pytest.raises(TissueError, match=r"is of another run than .*scene is rod.tis"):
        command("report", "bare.vtkhdf", "--validation", "rod.json")
    changed = json.loads(out) | {"springs": 4}
    (folder / "other.json").write_text(json.dumps(changed))
    with pytest.raises(TissueError, match="its springs is 4, and not 3"):
        command("report", "rod.vtkhdf", "--validation", "other.json")


@pytest.mark.parametrize("text", ["{", "[]", "{}", '{"verdict": "kept", "quantities": [1]}'])
def test_what_is_no_validation_is_refused(folder, text):
    (folder / "wrong.json").write_text(text)
    with pytest.raises(TissueError, match=r"an output of tissuec validate --json|cannot read"):
        command("report", "rod.vtkhdf", "--validation", "wrong.json")


def test_a_broken_promise_is_the_verdict_and_ends_with_one(folder, monkeypatch):
    from tissuec.cli import validate

    broken = {"verdict": "broken", "reasons": ["position is wrong"], "tolerance": 1e-4}
    monkeypatch.setattr(validate, "validated", lambda *arguments: broken)
    code, _, err = command("report", "rod.vtkhdf", "--validate")
    assert code == 1 and "validated: errors exceed their limits" in err
    page = Page((folder / "rod.report.html").read_text(encoding="utf-8"))
    assert "✗ FAIL: errors exceed their limits" in page.section("validation").text
    assert "bad" in page.root.all("div", "verdict")[0].attributes["class"]


def test_what_cannot_be_compiled_cannot_be_validated(tmp_path, example):
    example.saved(tmp_path / "made_up.vtkhdf")
    with pytest.raises(TissueError, match=r"cannot validate .*cannot be compiled again"):
        command("report", tmp_path / "made_up.vtkhdf", "--validate")


def test_unfinished_runs_have_pages_under_their_names(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run(tmp_path, UNSTABLE, "wild")
    code, _, err = command("report", "wild.partial.vtkhdf")
    assert code == 0 and "stopped" in err
    assert (tmp_path / "wild.partial.report.html").exists()


def test_the_page_opens_in_a_browser(folder, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    command("report", "rod.vtkhdf", "--open")
    assert opened == [(folder / "rod.report.html").as_uri()]


def test_results_that_are_none_are_refused_as_elsewhere(folder):
    with pytest.raises(TissueError, match="there is no file"):
        command("report", "nothing.vtkhdf")
    with pytest.raises(TissueError, match="it is a scene; run it first"):
        command("report", "rod.tis")
