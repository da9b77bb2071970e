"""Scenes compiled from texts that were kept, without the files that they came from."""

import pytest

from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.pipeline import compile_request, read_words
from tissuec.scene.program.imports import StoredTexts
from tissuec.scene.request import Request

TISSUE = (
    "language 1\ntissue gum { spring constant = 40 N/m; viscosity = 1 mN*s/m; mass = 5 g }\n"
)
USING = 'language 1\nuse "tissues/gum"\n'


def kept(text, **texts):
    names = {f"{name.replace('_', '/')}.tis": text for name, text in texts.items()}
    return read_words(Request(Source("scene.tis", text), files=StoredTexts(names)))[0]


def test_what_is_kept_counts_and_no_file_beside_it():
    words = kept(USING, tissues_gum=TISSUE)
    assert words.tissues["gum"].given["spring constant"].value == 40.0
    with pytest.raises(CompileError, match=r'"tissues/muscle.tis" is not stored in the result'):
        kept('language 1\nuse "tissues/muscle"\n')


def test_places_have_the_names_of_old():
    words = kept(USING, tissues_gum=TISSUE)
    assert words.tissues["gum"].span.place == "tissues/gum.tis:2"


def test_kept_texts_that_use_one_another_in_a_circle_end():
    with pytest.raises(CompileError, match="circle"):
        kept(USING, tissues_gum=USING)


TABLED = """language 1
tissue gum { spring constant = 40 N/m; viscosity = 1 mN*s/m; mass = 5 g }
body pair { mesh is explicit; tissue is gum }
table nodes of pair in mm with columns "id x" { 1 0; 2 10 }
table springs of pair with columns "a b" { 1 2 }
set left = nodes of pair in [1]
environment { gravity = (0, 0, 0) m/s^2 }
script { from 0 s to 1 s: move left by (1, 0, 0) mm using table "rise.csv" }
simulate { duration = 1 s }
"""


def test_tables_are_kept_too(tmp_path):
    (tmp_path / "scene.tis").write_text(TABLED)
    (tmp_path / "rise.csv").write_text("0,0\n1,2\n")
    request = Request.file(tmp_path / "scene.tis")
    from tissuec.compiler.manifest import manifest_of

    written = manifest_of(compile_request(request)[0], request)
    assert written["sources"] == {"rise.csv": "0,0\n1,2\n"}
    again = Request(Source("elsewhere.tis", TABLED), files=StoredTexts(written["sources"]))
    (profile,) = compile_request(again)[0].plan.events[0].action.profiles
    assert profile.values[-1] == 2.0
