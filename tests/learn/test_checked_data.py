"""``check`` and editors read the data of learn blocks, and report what a learning would."""

import pytest

from tests.every import every
from tissuec.core.errors import CompileError, as_dict
from tissuec.learn.fit.misfit import mistakes
from tissuec.learn.fit.session import prepare
from tissuec.lsp.documents import OpenDocuments
from tissuec.lsp.findings import check
from tissuec.pipeline import check_request, compile_request
from tissuec.scene.request import Request

SCENE = """language 1
param depth = 1 mm between 0 mm and 2 mm
tissue gum { spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 10 g }
body cord { mesh is explicit; tissue is gum }
table nodes of cord in mm with columns "id x" { 1 0; 2 10 }
table springs of cord with columns "a b" { 1 2 }
set top = nodes of cord in [2]
set base = nodes of cord in [1]
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix base
  from 0 s to 0.2 s: move top by (depth, 0 mm, 0 mm) using constant speed
}
simulate { duration = 0.3 s }
learn pull {
  data "one.csv"
  data "two.csv" { depth = 2 mm }
  fit = force(top) using column "force_N" in N
  adjust spring constant of gum
}
"""
GOOD = "t_s,force_N\n0,0\n0.1,0.02\n0.2,0.04\n"

#: What is replaced in the scene or in a file, and what is said at which place.
WRONG = {
    "column": (('"force_N"', '"force"'), '"force"', 'one.csv has no column "force"'),
    "unit": (("force_N", "force (mN)"), '"force (mN)"', "another unit than the one after in"),
    "number": (("0.02", "two"), '"force_N"', "one.csv"),
    "empty": ((GOOD, ""), '"one.csv"', "one.csv is empty"),
    "late": (("0.2,0.04", "0.9,0.04"), '"one.csv"', "one.csv ends at"),
    "few": (
        ("adjust spring constant of gum\n", "adjust mass of cord per node\n"
         "  adjust rest length of cord per spring\n  adjust spring constant of gum\n"
         "  adjust viscosity of gum\n  hold out = 0.9\n"),
        "learn pull", "fewer than the",
    ),
    "depth": (("depth = 2 mm }", "depth = 3 mm }"), "depth = 3 mm", "depth"),
}  # fmt: skip


OVER = 'displacement of top along (1, 0, 0) using column "t_s" in mm\n  fit'
#: The same where rows have displacements in place of times.
UNREACHED = {
    "too far": ("(depth, 0 mm, 0 mm)", "(0.1, 0, 0) mm", "a row has a displacement of 200 um"),
    "no motion": ("top by", "base by", "the script does not move the nodes"),
}


def _put(folder, old="", new=""):
    path = folder / "pull.tis"
    path.write_text(SCENE.replace(old, new) if old else SCENE)
    (folder / "one.csv").write_text(GOOD.replace(old, new) if old else GOOD)
    (folder / "two.csv").write_text(GOOD)
    return path


def _said(folder, step):
    with pytest.raises(CompileError) as raised:
        step()
    return [as_dict(one) for one in raised.value.diagnostics if one.severity == "error"]


@every("name", WRONG)
def test_wrong_data_is_reported_as_by_a_learning(name, tmp_path):
    (old, new), place, words = WRONG[name]
    path = _put(tmp_path, old, new)
    request = Request.file(path)
    said = _said(tmp_path, lambda: check_request(request))

    def learning():
        compiled, _ = compile_request(request)
        prepare(compiled, compiled.fit_problems[0], request)

    assert said == _said(tmp_path, learning)
    assert [one["message"].count(words) for one in said] == [1]
    found = check(OpenDocuments(), path).diagnostics
    assert [as_dict(one) for one in found if one.severity == "error"] == said
    assert all(place in one.span.text or one.span.text in place for one in found)


def test_good_data_is_checked_in_silence_and_only_where_there_is_time(tmp_path):
    path = _put(tmp_path)
    assert check_request(Request.file(path))[1] == ()
    documents = OpenDocuments()
    (tmp_path / "one.csv").write_text("")
    quick = check(documents, path, thorough=False)
    assert quick.diagnostics == () and not quick.is_thorough
    assert [one.code for one in check(documents, path).diagnostics] == ["TIS313"]


def _prepared(folder, *replaced):
    path = _put(folder)
    text = path.read_text()
    for old, new in replaced:
        text = text.replace(old, new)
    path.write_text(text)
    request = Request.file(path)
    compiled, _ = compile_request(request)
    return prepare(compiled, compiled.fit_problems[0], request)


def test_data_with_the_opposite_sign_is_named_with_its_way_out(tmp_path):
    turned = [("force(top)", "force(top along (-1, 0, 0))")]
    (said,) = mistakes(_prepared(tmp_path, *turned).problem)
    assert said == (
        "the data of force(top along (-1, 0, 0)) has the opposite sign of the first "
        "prediction: reverse the direction after along, or change the sign of the data"
    )
    back = [("force(top)", "force(top along (1, 0, 0))")]
    assert mistakes(_prepared(tmp_path, *back).problem) == []


def test_a_quantity_that_another_one_stands_for_is_named(tmp_path):
    """Springs have a constant in place of a modulus; the hint is followed."""
    old = "adjust spring constant of gum"
    with pytest.raises(CompileError) as raised:
        _prepared(tmp_path, (old, "adjust Young's modulus of gum"))
    (one,) = raised.value.diagnostics
    assert one.message == "gum has no Young's modulus as a number"
    assert one.hint == "gum has the spring constant: adjust spring constant"
    (edit,) = one.hint.edits
    _prepared(tmp_path, (old, f"adjust {edit.text} of gum"))


@every("name", UNREACHED)
def test_displacements_that_the_script_does_not_reach_are_reported_as_by_a_learning(
    name, tmp_path
):
    old, new, words = UNREACHED[name]
    replaced = [("fit", OVER), (old, new), ("  at 0 s: fix base", "")]
    said = _said(tmp_path, lambda: _prepared(tmp_path, *replaced))
    assert said[0]["message"].startswith(words)
    line = 1 + (tmp_path / "pull.tis").read_text().split("displacement of")[0].count("\n")
    assert said[0]["line"] == line  # and not that of the fit
    assert said == _said(tmp_path, lambda: check_request(Request.file(tmp_path / "pull.tis")))
