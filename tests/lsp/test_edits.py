"""Changes of parts of a text give the text that the editor shows."""

from hypothesis import given
from hypothesis import strategies as st

from tissuec.lsp.positions import ProtocolPosition, Replacement, replaced

# Line ends of the protocol, what only Python takes for some, and letters of several units.
LETTERS = st.text(st.sampled_from("ab \n\r\u2028\x0c\x85äé😀"), max_size=12)
WIDTHS = {"utf-8": "utf-8", "utf-16": "utf-16-le", "utf-32": "utf-32-le"}
UNIT = {"utf-8": 1, "utf-16": 2, "utf-32": 4}


def place(text: str, offset: int, encoding: str) -> ProtocolPosition:
    """Return a place as an editor counts it: lines end with \\n, \\r\\n or \\r alone."""
    before = text[:offset].replace("\r\n", "\n").replace("\r", "\n")
    line = before.count("\n")
    column = before[before.rfind("\n") + 1 :]
    return ProtocolPosition(line, len(column.encode(WIDTHS[encoding])) // UNIT[encoding])


@given(text=LETTERS, new=LETTERS, data=st.data(), encoding=st.sampled_from(sorted(WIDTHS)))
def test_a_stretch_is_replaced_wherever_it_is(text, new, data, encoding):
    # Between the two halves of a line end there is no place.
    places = [n for n in range(len(text) + 1) if text[n - 1 : n + 1] != "\r\n" or not n]
    start, stop = sorted(data.draw(st.sampled_from(places)) for _ in range(2))
    change = Replacement(place(text, start, encoding), place(text, stop, encoding), new)
    assert replaced(text, [change], encoding) == text[:start] + new + text[stop:]


def test_places_beyond_a_line_or_the_text_are_its_end():
    end = ProtocolPosition(0, 99)
    assert replaced("ab\ncd", [Replacement(end, end, "!")], "utf-16") == "ab!\ncd"
    below = ProtocolPosition(9, 0)
    assert replaced("ab\ncd", [Replacement(below, below, "!")], "utf-16") == "ab\ncd!"
    several = [Replacement(end, end, "!"), Replacement(end, end, "?")]
    assert replaced("ab", several, "utf-16") == "ab!?"
