"""Offsets of the compiler and places of an editor, there and back."""

import pytest

from tissuec.lang.characters import normalise
from tissuec.lsp.positions import Positions

ODD = '\ufefflanguage 1\r\nabout "Gänse 𝄞 😀" # cafe\u0301 x\r\nparam ä = 1 mm # 😀\rlet b = 2'


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-32"])
def test_every_offset_is_found_again(encoding):
    read = normalise(ODD, "odd").text
    positions = Positions(ODD, encoding)
    for offset in range(len(read) + 1):
        assert positions.offset(*positions.position(offset)) == offset


def test_characters_beyond_the_first_plane_count_twice():
    read = normalise(ODD, "odd").text
    positions = Positions(ODD)
    assert positions.position(read.index("# caf")) == (1, len('about "Gänse 𝄞 😀" ') + 2)
    assert positions.position(read.index("let b")) == (3, 0)


def test_a_composed_letter_is_two_characters_where_the_editor_has_two():
    read = normalise(ODD, "odd").text
    place = Positions(ODD).position(read.index(" x"))
    assert (
        ODD.split("\r\n")[1]
        .encode("utf-16-le")[: 2 * place.character]
        .decode("utf-16-le")
        .endswith("cafe\u0301")
    )


def test_places_beyond_a_line_or_the_text_are_its_end():
    positions = Positions("a\nbc")
    assert positions.offset(0, 99) == 1
    assert positions.offset(7, 0) == 4
    assert positions.position(99) == (1, 2)
