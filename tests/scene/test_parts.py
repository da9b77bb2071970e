"""Every part and entry of the language is declared once, with a meaning and a form."""

import pytest

from tests.every import every
from tissuec.lang.unopened import begins_block
from tissuec.lang.words import MEANINGS, RESERVED
from tissuec.scene.parts import PARTS, blocks, forms_of, parts, sharing

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
    ("word", "others"), [("body", "param"), ("property", "quantity"), ("force", "set")]
)
def test_some_parts_share_their_names(word, others):
    assert others in sharing(word)
    assert sharing("tissue") == ["tissue"]


def test_the_parser_knows_which_words_begin_blocks():
    words = {*parts("named", "single"), "region"}
    assert all(begins_block(word) for word in words)
    assert not any(begins_block(word) for word in ("param", "mesh", "hedge", "springs"))
    alone = {word for word in words if begins_block(word, alone=True)}
    assert alone == {"environment", "script", "simulate", "output"}
