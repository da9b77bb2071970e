"""What is said about a place: values in SI units, reasons, meanings."""

import pytest

from tests.every import every
from tests.lsp.editor_documents import LIBRARY, asked, shipped
from tissuec.compiler.provenance import explain_tissue
from tissuec.core.resources import library
from tissuec.lsp.documents import OpenDocuments
from tissuec.lsp.findings import check
from tissuec.lsp.hover import hover
from tissuec.lsp.views import view_of

STERILISATION = shipped("scenes/sterilisation.tis")
TUBE = "tissues/fallopian_tube"


def said(text):
    """Return what is said at the mark of a text."""
    found = hover(*asked(text))
    return found.text if found else ""


def at(text, place):
    """Return what is said in the middle of a place of a text."""
    start = text.index(place) + len(place) // 2
    return said(f"{text[:start]}‸{text[start:]}")


def scar(entry):
    """Return a text with a tissue like another one."""
    return f'language 1\nuse "{TUBE}"\ntissue scar like fallopian tube {{ {entry} }}\n'


@pytest.mark.parametrize(
    ("written", "value"),
    [
        ("6 mm", "`0.006 m`: a length (m)"),
        ("4 %", "`0.04`: a plain number"),
        ("30 mN*s/m", "`0.03 N*s/m`: force per speed (N*s/m)"),
        ("2.5e3 kPa", "`2500000 Pa`: a pressure (Pa)"),
        ("90 deg", "`1.570796327`: a plain number"),
    ],
)
def test_a_number_is_said_in_si_units(written, value):
    text = f"language 1\nparam a = {written}\n"
    assert at(text, written) == f"`{written}` is {value}"


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("adjust", "parameters"), ("stiffening", "to be learned"), ("passes", "optimiser"),
        ("positions", "positions of all nodes"), ("free zero", "unknown constant"),
        ("node", "its own number"), ("least squares", ""),
    ],
)  # fmt: skip
def test_entries_of_learn_blocks_are_explained(place, words):
    text = (
        'language 1\nlearn t { fit = positions(A) using columns "a" in mm with free zero\n'
        "adjust stiffening\nadjust mass of A per node; passes = 3; method is least squares }\n"
    )
    found = at(text, place)
    assert found
    assert words in found


@every(
    ("place", "words"),
    [
        ("vary", "vary lift = [2 mm, 5 mm]"), ("lift = 1", "`6 mm`"), ("pull =", "a column of"),
        ("max(f", "the largest value"), ("force(", "force"), ("rupture", "first event"),
        ("latin", "random points"), ("keep", "what is kept"), ("share", "share(NAME < 2 N)"),
        ("pull >", "measure pull = max"),
    ],
)  # fmt: skip
def test_sentences_of_studies_are_explained(place, words):
    text = (
        "language 1\nparam lift = 6 mm\nstudy s { vary lift = 1 mm to 3 mm\n"
        "measure pull = max(force(A))\nmeasure tear = time of rupture\n"
        "design is latin hypercube; keep is results; expect share(pull > 1 N) == 1 }\n"
    )
    assert words.lower() in at(text, place).lower()


def test_the_unit_of_a_vector_is_what_one_of_it_is():
    assert "`mm` is `0.001 m`" in said("language 1\nlet a = (1, 2, 3) m‸m\n")


def test_params_and_lets_have_their_values_and_remarks():
    text = (
        "language 1\nparam lift = 6 mm between 0 mm and 9 mm  # of forceps\nlet a = 2 * lift\n"
    )
    assert "`6 mm` = `0.006 m`: a length (m)" in at(text, "lift = 6")
    assert "of forceps" in at(text, "* lift")
    assert "`12 mm` = `0.012 m`" in said(text.replace("let a", "let ‸a"))


def test_a_param_is_known_while_the_rest_is_half_typed():
    text = "language 1\nparam lift = 6 mm\nbody b { mesh is tu\nlet a = 2 * li‸ft\nset = (("
    assert "`6 mm`" in said(text)


@every("path", LIBRARY)
def test_a_tissue_is_said_as_explain_says_it(path):
    view = view_of(OpenDocuments(), path)
    for symbol in view.of_kind("tissue"):
        tissue = view.tissue(symbol.key)
        if symbol.span.source is not view.source:
            continue
        text = hover(view, symbol.span.start).text
        for explained in explain_tissue(tissue):
            assert f"{explained.quantity} of {tissue.name}: `{explained.shown}`" in text
            for reason in explained.reasons:
                place = reason.place.rsplit(":", 1)
                where = f"line {place[1]}" if place[0] == view.source.name else reason.place
                assert where in text
                if reason.degree is not None:
                    assert f"{reason.said}: `if " in text
                    assert reason.facts in text


def test_a_tissue_is_said_with_what_is_known_of_it():
    text = (
        "language 1\ntissue gel‸ { Young's modulus = 5 kPa\n"
        'known Young\'s modulus from 3 kPa to 7 kPa by unverified "A" }'
    )
    told = said(text)
    assert "Young's modulus of gel: `5 kPa` (written)" in told
    assert "- known Young's modulus: `3 kPa to 7 kPa`, A (unverified), line 3" in told


def test_a_quantity_in_a_tissue_has_its_value_and_the_line_that_gave_it():
    text = scar("viscosity = 3 mN*s/m")
    assert "viscosity of scar: `3 mN*s/m` (written)" in at(text, "viscosity")
    assert "`viscosity = 3 mN*s/m`, line 3" in at(text, "viscosity")


def test_a_word_says_what_it_stands_for():
    text = scar("hardness is very hard")
    assert "value `0.917`, range `0.5` to `1`" in at(text, "hard }")
    assert "hedge very = shift(50 %, outward)" in at(text, "very")
    assert "very hard has the value `0.9583`" in at(text, "hardness")


@every(
    ("place", "sentence"),
    [
        ("body", "A mesh made of tissue."),
        ("mesh is", "The mesh of nodes and springs."),
        ("tube {", "An open tube"),
        ("radius", "a length (m), above 0 m"),
        ("interior", "`none`"),
        ("grasp", "grasp SET with TOOL"),
        ("smooth profile", "A time profile."),
        ("facing", "The normal direction of a plane."),
        ("gravity", "Acceleration of free fall"),
        ("tolerance", "a plain number"),
        ("automatic", "Chosen automatically"),
        ("param", "set on the command line"),
        ("count(", "count(nodes of A)"),
    ],
)
def test_words_of_the_language_are_explained(place, sentence):
    assert sentence in at(STERILISATION, place)


def test_sets_and_bodies_are_counted_once_the_scene_is_right():
    documents, path = OpenDocuments(), library() / "scenes" / "sterilisation.tis"
    view, compiled = view_of(documents, path), check(documents, path, thorough=False).compiled
    body = hover(view, view.source.text.index("body oviduct") + 6, compiled)
    chosen = hover(view, view.source.text.index("uterine end") + 1, compiled)
    assert "160 nodes, 610 springs" in body.text
    assert "10 nodes" in chosen.text


def test_a_code_is_explained_where_it_stands(tmp_path):
    documents, path = OpenDocuments(), tmp_path / "scene.tis"
    documents.put(path, "language 1\nlet a = b\n")
    view, found = view_of(documents, path), check(documents, path)
    said = hover(view, 19, None, found.diagnostics)
    assert "**TIS301: " in said.text


def test_nothing_is_said_of_remarks_and_blanks():
    assert said("language 1\n# a bo‸dy\n") == ""
    assert said("language 1\n‸\n\n") == ""
