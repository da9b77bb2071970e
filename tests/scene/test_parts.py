"""Every part and entry of the language is declared once, with a meaning and a form."""

import subprocess
import sys

import pytest

from tests.every import every
from tissuec.lang.unopened import begins_block
from tissuec.lang.words import MEANINGS, RESERVED
from tissuec.scene.reading.parts import PARTS, blocks, forms_of, parts, share_names

ENTRIES = [
    (kind, name) for kind, block in sorted(blocks().items()) for name in block.entries("")
]


@every("word", [*parts()])
def test_every_part_has_a_meaning_and_forms_that_begin_with_its_word(word):
    assert PARTS[word].about.endswith(".")
    assert all(form.startswith(word) for form in forms_of(word))


@every("kind_and_name", ENTRIES)
def test_every_entry_has_a_meaning_and_forms_that_begin_with_its_name(kind_and_name):
    kind, name = kind_and_name
    entry = blocks()[kind].entries("")[name]
    assert entry.about
    assert entry.name.lower() == name and entry.forms
    assert all(form.startswith(entry.name) for form in entry.forms)


def test_every_part_has_its_own_place_in_lists():
    places = [part.place for part in parts().values()]
    assert sorted(set(places)) == places


def test_every_reserved_word_has_a_meaning():
    assert set(MEANINGS) | set(parts()) >= RESERVED


@pytest.mark.parametrize(
    ("word", "other"), [("body", "param"), ("property", "quantity"), ("force", "set")]
)
def test_some_parts_share_their_names(word, other):
    assert share_names(word, other)
    assert [one for one in parts() if share_names("tissue", one)] == ["tissue"]


def test_the_parser_knows_which_words_begin_blocks():
    words = {*parts("named", "single"), "region"}
    assert all(begins_block(word) for word in words)
    assert not any(begins_block(word) for word in ("param", "mesh", "hedge", "springs"))
    alone = {word for word in words if begins_block(word, alone=True)}
    assert alone == {"environment", "script", "simulate", "output"}


#: One more entry of environment, as a field of the class that declares them.
ONE_MORE = r"""
from pathlib import Path
from typing import Annotated
from tissuec.core import units
from tissuec.core.errors import CompileError
from tissuec.core.fields import Real
from tissuec.core.source import Source
from tissuec.scene import environment

class Windy(environment.EnvironmentEntries, frozen=True, eq=False):
    '''What acts everywhere.

    Attributes:
        wind: speed of the air
    '''

    wind: Annotated[float, Real(units.VELOCITY, at_least=0.0)] = 0.0

environment.EnvironmentEntries = Windy

from tissuec.lsp.completion import complete
from tissuec.lsp.documents import OpenDocuments
from tissuec.lsp.highlighting import grammar
from tissuec.lsp.hover import hover
from tissuec.lsp.semantic_tokens import tokens
from tissuec.lsp.views import view_of
from tissuec.pipeline import check_request
from tissuec.scene.reading.entries import entry_table
from tissuec.scene.request import Request

def said(entry):
    text = f"language 1\nenvironment {{ {entry} }}\n"
    try:
        return [str(one) for one in check_request(Request(Source("a.tis", text)))]
    except CompileError as error:
        return " ".join(map(str, error.diagnostics))

assert "wind must be a speed" in said("wind = 3 mm"), said("wind = 3 mm")
assert "at least 0 m/s" in said("wind = -3 m/s")
assert 'did you mean "wind"' in said("wnd = 3 m/s")
assert "| `wind = …` | a speed (m/s)" in entry_table(environment.environment_entries())
documents, path = OpenDocuments(), Path("a.tis")
documents.put(path, "language 1\nenvironment { wind = 3 m/s }\n")
view = view_of(documents, path)
assert "Speed of the air." in hover(view, 27).text
assert "wind" in [one.label for one in complete(view, 25)]
assert {kind for start, _, kind in tokens(view.source.text) if start == 25} == {"entry"}
assert "wind" in str(grammar()["repository"]["environment-part"])
"""


def test_a_new_entry_is_a_field_in_one_file():
    done = subprocess.run(
        [sys.executable, "-c", ONE_MORE], capture_output=True, text=True, encoding="utf-8"
    )
    assert done.returncode == 0, done.stdout + done.stderr
